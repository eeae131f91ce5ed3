"""The particle filter as a Drake system."""

from collections.abc import Callable, Sequence
from dataclasses import fields
import time as wall_clock

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
from pbpf_drake.dope_measurement import DopeMeasurement, EvalDopeMeasurement
from pbpf_drake.filtering import joint_samples, recent_detections
from pbpf_drake.filtering.belief_covariance import belief_covariances
from pbpf_drake.filtering.discrete_arrays import DiscreteArrays
from pbpf_drake.filtering.filter_scratch import FilterScratch
from pbpf_drake.filtering.filter_state import FilterState, MakeInitialState
from pbpf_drake.filtering.particle_filter_update import ParticleFilterUpdate
from pbpf_drake.filtering.resampling import effective_sample_size
from pbpf_drake.motion.motion_model import MotionScratch
from pbpf_drake.poses.pose_conversion import rigid_transform

# What is in the discrete state beside FilterState: the joints and detections
# since the last update, and when that was.
_SAMPLES = "joint_samples"
_DETECTIONS = "recent_detections"
_UPDATE_TIME = "update_time"


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
    of its model (in radians or meters), sampled ``control_samples`` times per
    period. Where a value isn't finite, the joint's last one is held. Input
    ``joint_velocities``: (n,) bends the path between two samples. Input
    ``dope_measurement``: a DopeMeasurement; a detection is used if its stamp
    is new, not of the future and at most ``max_detection_age`` old, and if its
    pose is finite and within 1 km.

    Output ``estimated_poses``: list of K RigidTransform X_WO, the weighted
    mean of the particles. Output ``particles``: (M, K, 7) in row-major order:
    qw qx qy qz (unit), x y z (in meters). Output ``weights``: (M,), sum 1.
    Output ``effective_sample_size``: from 1 to n. Output ``particles_used``:
    n, less than M with ``adaptive_count``; then the other particles repeat the
    first n with a weight of 0. Output ``covariances``: (K, 6, 6) in row-major
    order: rotation vector (in radians), then position (in meters), in the
    world. Outputs ``tracked`` and ``detected``: (K,) 1 if the object has been
    detected, ever and at the last update, else 0. Output ``update_time``: of
    the last update (in seconds), -1 before it.

    Before an object is first detected, its estimate and particles are the
    nominal pose that the scene gives it, its covariance is that of the initial
    noise, and it takes no part in the physics of the others.

    State: all of it is discrete. No port has direct feedthrough. Randomness is
    a pure function of (seed, step). Only with ``adaptive_count.to_period`` does
    anything depend on wall times; those of the last updates are no state, and a
    cloned context starts without them.

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
        rows = config.control_samples + 1
        num_objects = len(object_names)
        self._arrays = DiscreteArrays(
            self.DeclareDiscreteState,
            {
                **vars(MakeInitialState(config.num_particles, nominal_poses)),
                _SAMPLES: joint_samples.make_empty_rows(rows, num_joints),
                _DETECTIONS: recent_detections.make_empty_rows(
                    num_objects, rows
                ),
                _UPDATE_TIME: np.array([-1.0]),
            },
        )
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

    def _DeclareOutputs(self) -> None:
        index = self._arrays.index
        num_objects = len(self._object_names)
        poses, weights, estimates, num_estimates = (
            self.discrete_state_ticket(index(name))
            for name in ("poses", "weights", "estimates", "num_estimates")
        )
        self.DeclareAbstractOutputPort(
            "estimated_poses",
            alloc=lambda: Value([RigidTransform()] * num_objects),
            calc=self._CalcEstimatedPoses,
            prerequisites_of_calc={estimates},
        )
        self.DeclareStateOutputPort("particles", index("poses"))
        self.DeclareStateOutputPort("weights", index("weights"))
        self.DeclareVectorOutputPort(
            "effective_sample_size",
            1,
            calc=self._CalcEffectiveSampleSize,
            prerequisites_of_calc={weights},
        )
        self.DeclareStateOutputPort("particles_used", index("num_used"))
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
        self.DeclareStateOutputPort("detected", index("detected"))
        self.DeclareStateOutputPort("update_time", index(_UPDATE_TIME))

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
        samples = self._Read(context, _SAMPLES)
        if np.isfinite(samples[-1, 0]) and samples[-1, 0] <= context.get_time():
            return
        sample = self._ReadJoints(context, samples[-1])
        self._arrays.Write(values, _SAMPLES, np.tile(sample, len(samples)))
        self._arrays.Write(values, _UPDATE_TIME, np.array([-1.0]))

    def _Sample(self, context: Context, values: DiscreteValues) -> None:
        """Keeps joints and detections until the next update."""
        samples = self._Read(context, _SAMPLES)
        now = self._ReadJoints(context, samples[-1])
        samples = joint_samples.append_row(samples, now)
        self._arrays.Write(values, _SAMPLES, samples)
        detections = self._ReadDetections(context)
        self._arrays.Write(values, _DETECTIONS, detections)

    def _Update(self, context: Context, values: DiscreteValues) -> None:
        start = wall_clock.perf_counter()
        self._Sample(context, values)
        samples = self._arrays.Read(values, _SAMPLES)
        detections = self._arrays.Read(values, _DETECTIONS)
        (last_time,) = self._Read(context, _UPDATE_TIME)
        bend = self._velocities_port.HasValue(context)
        state = self._State(context)
        scratch = self.get_cache_entry(self._scratch_index).Eval(context)
        to_period = self._config.adaptive_count.to_period
        state = self._update.Update(
            state,
            path=joint_samples.path_since(samples, last_time, bend=bend),
            detections=recent_detections.unused_detections(
                detections, state.detection_times
            ),
            scratch=scratch.ForUpdate(),
            most=scratch.pace.MaxParticles() if to_period else None,
        )
        for name, array in vars(state).items():
            self._arrays.Write(values, name, array)
        self._arrays.Write(values, _UPDATE_TIME, np.array([context.get_time()]))
        seconds = wall_clock.perf_counter() - start
        scratch.pace.AddUpdate(seconds, int(state.num_used[0]))
        if self._on_update:
            self._on_update(seconds)

    def _State(self, context: Context) -> FilterState:
        names = [field.name for field in fields(FilterState)]
        return FilterState(**{n: self._Read(context, n) for n in names})

    def _Read(self, context: Context, name: str) -> np.ndarray:
        return self._arrays.Read(context.get_discrete_state(), name)

    def _ReadJoints(self, context: Context, last: np.ndarray) -> np.ndarray:
        """Returns the sample of now."""
        positions, velocities = self._positions_port.Eval(context), None
        if self._velocities_port.HasValue(context):
            velocities = self._velocities_port.Eval(context)
        time = context.get_time()
        return joint_samples.make_row(time, positions, velocities, last)

    def _ReadDetections(self, context: Context) -> np.ndarray:
        """Returns the stored detections with those of now."""
        stored = self._Read(context, _DETECTIONS)
        if not self._measurement_port.HasValue(context):
            return stored
        return recent_detections.add_measurement(
            stored,
            EvalDopeMeasurement(self, context),
            object_names=self._object_names,
            now=context.get_time(),
            max_age=self._config.max_detection_age,
        )

    def _CalcEstimatedPoses(
        self, context: Context, output: AbstractValue
    ) -> None:
        poses = self._State(context).estimates[0]
        output.set_value([rigid_transform(pose) for pose in poses])

    def _CalcEffectiveSampleSize(
        self, context: Context, output: BasicVector
    ) -> None:
        weights = self._State(context).weights
        output.SetFromVector([effective_sample_size(weights)])

    def _CalcCovariances(self, context: Context, output: BasicVector) -> None:
        state, noise = self._State(context), self._config.initial_noise
        output.SetFromVector(belief_covariances(state, noise).ravel())

    def _CalcTracked(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(1.0 * (self._State(context).num_estimates > 0))
