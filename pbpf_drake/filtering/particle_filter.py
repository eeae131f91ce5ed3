"""The particle filter as a Drake system."""

from collections.abc import Callable, Sequence
from dataclasses import fields
import time as wall_clock
from typing import TypeVar

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.dope_measurement import DopeMeasurement
from pbpf_drake.filtering.belief_covariance import belief_covariances
from pbpf_drake.filtering.filter_scratch import FilterScratch
from pbpf_drake.filtering.filter_state import FilterState, MakeInitialState
from pbpf_drake.filtering.joint_samples import (
    append_sample,
    make_empty_samples,
    make_sample,
    path_since,
)
from pbpf_drake.filtering.particle_filter_update import ParticleFilterUpdate
from pbpf_drake.filtering.recent_detections import (
    add_detections,
    make_empty_detections,
    unused_detections,
)
from pbpf_drake.filtering.resampling import effective_sample_size
from pbpf_drake.poses.pose_conversion import rigid_transform

# Of the motion model; the system doesn't look into it.
MotionScratch = TypeVar("MotionScratch")


class PhysicsBasedParticleFilter(LeafSystem):
    """Tracks the poses of K objects with M particles (Section 4).

    Every ``period`` it predicts the particles from what the robot did, weighs
    them by the detections, and resamples; see ParticleFilterUpdate. With the
    constant-velocity motion model it is the paper's CVPF, with a visibility
    model its PBPF-V.

    .. pydrake_system::

        name: PhysicsBasedParticleFilter
        input_ports:
        - joint_positions
        - joint_velocities (optional)
        - dope_measurement (optional)
        output_ports:
        - estimated_poses
        - particles
        - weights
        - effective_sample_size
        - particles_used
        - covariances
        - tracked
        - detected
        - update_time

    Input ``joint_positions``: (n,) the robot's measured joints, in the order
    of its model (in radians or meters). It is sampled ``control_samples``
    times per period. A value that isn't finite is ignored: the joint's last
    one is held. Input ``joint_velocities``: (n,) bends the path between two
    samples. Input ``dope_measurement``: a DopeMeasurement; a detection is
    used if its stamp is new, not of the future and at most
    ``max_detection_age`` old, and if its pose is finite and within 1 km.

    Output ``estimated_poses``: list of K RigidTransform X_WO, the weighted
    mean of the particles. Output ``particles``: (M, K, 7) in row-major order:
    qw qx qy qz (unit), x y z (in meters). Output ``weights``: (M,), sum 1.
    Output ``effective_sample_size``: from 1 to n. Output ``particles_used``: n,
    the first of the M particles; the others repeat them with a weight of 0, and
    there are none if ``adaptive_count`` is off. Output ``covariances``:
    (K, 6, 6) in row-major order: rotation vector (in radians), then position
    (in meters), in the world. Outputs ``tracked`` and ``detected``: (K,) 1 if
    the object has been detected, ever and at the last update, else 0. Output
    ``update_time``: time of the last update (in seconds), -1 before it.

    Before the first detection of an object its estimate and its particles are
    the nominal pose that the scene gives it, its covariance is that of the
    initial spread, and it takes no part in the physics of the others.

    State: all of it is discrete: particles with their velocities, weights,
    two estimates, counters, and the latest samples of the joints. No port has
    direct feedthrough. Randomness is a pure function of (seed, step). Only with
    ``adaptive_count.to_period`` does anything depend on wall times; those of
    the last updates are no state, and a cloned context starts without them.

    Args:
        config: checked here.
        update: the algorithm.
        object_names: K names by which detections are found.
        nominal_poses: (K, 7).
        num_joints: n.
        on_update: called after each update with its wall time (in seconds).

    Raises:
        ValueError: a field of the config is out of range.
    """

    def __init__(
        self,
        *,
        config: ParticleFilterConfig,
        update: ParticleFilterUpdate[MotionScratch],
        object_names: Sequence[str],
        nominal_poses: np.ndarray,
        num_joints: int,
        on_update: Callable[[float], None] | None = None,
    ) -> None:
        super().__init__()
        config.ValidateOrThrow()
        self._config = config
        self._update = update
        self._object_names = tuple(object_names)
        self._initial = MakeInitialState(config.num_particles, nominal_poses)
        self._on_update = on_update

        self._positions_port = self.DeclareVectorInputPort(
            "joint_positions", num_joints
        )
        self._velocities_port = self.DeclareVectorInputPort(
            "joint_velocities", num_joints
        )
        self._measurement_port = self.DeclareAbstractInputPort(
            "dope_measurement", Value(DopeMeasurement())
        )
        self._DeclareStates(num_joints)
        # Contexts and processes of the models: no information is in them.
        self._scratch_index = self.DeclareCacheEntry(
            "scratch",
            ValueProducer(
                allocate=lambda: Value(FilterScratch(update, config.period)),
                calc=ValueProducer.NoopCalc,
            ),
            {self.nothing_ticket()},
        ).cache_index()
        self._DeclareOutputs()
        self._DeclareEvents()

    def _DeclareStates(self, num_joints: int) -> None:
        self._state_index = {
            field.name: self.DeclareDiscreteState(
                np.ravel(getattr(self._initial, field.name))
            )
            for field in fields(FilterState)
        }
        num_samples = self._config.control_samples + 1
        samples = make_empty_samples(num_samples, num_joints)
        self._samples_shape = samples.shape
        self._samples_index = self.DeclareDiscreteState(samples.ravel())
        detections = make_empty_detections(len(self._object_names), num_samples)
        self._detections_shape = detections.shape
        self._detections_index = self.DeclareDiscreteState(detections.ravel())
        self._update_time_index = self.DeclareDiscreteState([-1.0])

    def _DeclareOutputs(self) -> None:
        num_objects = len(self._object_names)
        poses, weights, estimates, num_estimates = (
            self.discrete_state_ticket(self._state_index[name])
            for name in ("poses", "weights", "estimates", "num_estimates")
        )
        self.DeclareAbstractOutputPort(
            "estimated_poses",
            alloc=lambda: Value([RigidTransform()] * num_objects),
            calc=self._CalcEstimatedPoses,
            prerequisites_of_calc={estimates},
        )
        self.DeclareStateOutputPort("particles", self._state_index["poses"])
        self.DeclareStateOutputPort("weights", self._state_index["weights"])
        self.DeclareVectorOutputPort(
            "effective_sample_size",
            1,
            calc=self._CalcEffectiveSampleSize,
            prerequisites_of_calc={weights},
        )
        self.DeclareStateOutputPort(
            "particles_used", self._state_index["num_used"]
        )
        self.DeclareVectorOutputPort(
            "covariances",
            num_objects * 36,
            calc=self._CalcCovariances,
            prerequisites_of_calc={poses, weights, estimates, num_estimates},
        )
        self.DeclareVectorOutputPort(
            "tracked",
            num_objects,
            calc=self._CalcTracked,
            prerequisites_of_calc={num_estimates},
        )
        self.DeclareStateOutputPort("detected", self._state_index["detected"])
        self.DeclareStateOutputPort("update_time", self._update_time_index)

    def _DeclareEvents(self) -> None:
        period, samples = self._config.period, self._config.control_samples
        self.DeclareInitializationDiscreteUpdateEvent(update=self._Initialize)
        if samples > 1:
            self.DeclarePeriodicDiscreteUpdateEvent(
                period_sec=period / samples,
                offset_sec=period / samples,
                update=self._Sample,
            )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=period, offset_sec=period, update=self._Update
        )
        self.DeclareForcedDiscreteUpdateEvent(update=self._Update)

    def _Initialize(self, context: Context, values: DiscreteValues) -> None:
        """Fills the samples with where the joints are now.

        Where a simulation goes on from a context that has samples, they stay.
        """
        samples = self._StoredSamples(context)
        if np.isfinite(samples[-1, 0]) and samples[-1, 0] <= context.get_time():
            return
        sample = self._ReadJoints(context, samples[-1])
        values.get_mutable_value(self._samples_index)[:] = np.tile(
            sample, self._samples_shape[0]
        )
        values.get_mutable_value(self._update_time_index)[:] = -1.0

    def _Sample(self, context: Context, values: DiscreteValues) -> None:
        self._TakeSamples(context, values)

    def _TakeSamples(
        self, context: Context, values: DiscreteValues
    ) -> tuple[np.ndarray, np.ndarray]:
        """Keeps joints and detections until the next update; returns both."""
        samples = self._StoredSamples(context)
        samples = append_sample(samples, self._ReadJoints(context, samples[-1]))
        detections = self._ReadDetections(context)
        values.get_mutable_value(self._samples_index)[:] = samples.ravel()
        values.get_mutable_value(self._detections_index)[:] = detections.ravel()
        return samples, detections

    def _Update(self, context: Context, values: DiscreteValues) -> None:
        start = wall_clock.perf_counter()
        samples, detections = self._TakeSamples(context, values)
        state = self._State(context)
        scratch: FilterScratch = self.get_cache_entry(self._scratch_index).Eval(
            context
        )
        state = self._update.Update(
            state,
            path=path_since(
                samples,
                context.get_discrete_state(self._update_time_index).value()[0],
                bend=self._velocities_port.HasValue(context),
            ),
            detections=unused_detections(detections, state.detection_times),
            scratch=scratch.ForUpdate(),
            most=scratch.pace.MaxParticles()
            if self._config.adaptive_count.to_period
            else None,
        )
        for name, index in self._state_index.items():
            values.get_mutable_value(index)[:] = np.ravel(getattr(state, name))
        values.get_mutable_value(self._update_time_index)[:] = (
            context.get_time()
        )
        seconds = wall_clock.perf_counter() - start
        scratch.pace.AddUpdate(seconds, int(state.num_used[0]))
        if self._on_update:
            self._on_update(seconds)

    def _State(self, context: Context) -> FilterState:
        return FilterState(
            **{
                name: context.get_discrete_state(index)
                .value()
                .reshape(np.shape(getattr(self._initial, name)))
                for name, index in self._state_index.items()
            }
        )

    def _StoredSamples(self, context: Context) -> np.ndarray:
        return (
            context.get_discrete_state(self._samples_index)
            .value()
            .reshape(self._samples_shape)
        )

    def _ReadJoints(self, context: Context, last: np.ndarray) -> np.ndarray:
        """Returns the sample of now."""
        velocities = None
        if self._velocities_port.HasValue(context):
            velocities = self._velocities_port.Eval(context)
        positions = self._positions_port.Eval(context)
        return make_sample(context.get_time(), positions, velocities, last)

    def _ReadDetections(self, context: Context) -> np.ndarray:
        """Returns the stored detections with those of now."""
        stored = (
            context.get_discrete_state(self._detections_index)
            .value()
            .reshape(self._detections_shape)
        )
        if not self._measurement_port.HasValue(context):
            return stored
        measurement = self._measurement_port.Eval(context)
        if not isinstance(measurement, DopeMeasurement):
            raise TypeError(
                "The port dope_measurement holds a "
                f"{type(measurement).__name__}; expected a DopeMeasurement"
            )
        return add_detections(
            stored,
            measurement,
            object_names=self._object_names,
            now=context.get_time(),
            max_age=self._config.max_detection_age,
        )

    def _CalcEstimatedPoses(
        self, context: Context, output: AbstractValue
    ) -> None:
        estimates = self._State(context).estimates[0]
        output.set_value([rigid_transform(pose) for pose in estimates])

    def _CalcEffectiveSampleSize(
        self, context: Context, output: BasicVector
    ) -> None:
        weights = self._State(context).weights
        output.SetFromVector([effective_sample_size(weights)])

    def _CalcCovariances(self, context: Context, output: BasicVector) -> None:
        covariances = belief_covariances(
            self._State(context), self._config.initial_noise
        )
        output.SetFromVector(covariances.ravel())

    def _CalcTracked(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(1.0 * (self._State(context).num_estimates > 0))
