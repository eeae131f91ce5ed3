"""The particle filter as a Drake system."""

from collections.abc import Callable, Sequence
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
from pbpf_drake.filtering.filter_memory import FilterMemory
from pbpf_drake.filtering.filter_scratch import FilterScratch
from pbpf_drake.filtering.particle_filter_update import ParticleFilterUpdate
from pbpf_drake.filtering.recent_detections import ANYWHERE, RecentDetections
from pbpf_drake.filtering.resampling import effective_sample_size
from pbpf_drake.motion.motion_model import MotionScratch
from pbpf_drake.poses.pose_conversion import rigid_transform


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
        - detection_counts
        - num_rejected

    Input ``joint_positions``: (n,) the robot's measured joints, in the order
    of its model (in radians or meters), sampled ``control_samples`` times per
    period. Where a value isn't finite, the joint's last one is held. Input
    ``joint_velocities``: (n,) bends the path between two samples. Input
    ``dope_measurement``: a DopeMeasurement; a detection is used if its stamp
    is new, not of the future and at most ``max_detection_age`` old, and if its
    pose is finite and within bounds. It weighs where particles were then.

    Output ``estimated_poses``: list of K RigidTransform X_WO, the weighted
    mean of the particles. Output ``particles``: (M, K, 7) in row-major order:
    qw qx qy qz (unit), x y z (in meters). Output ``weights``: (M,), sum 1.
    Output ``effective_sample_size``: from 1 to n. Output ``particles_used``:
    n, less than M with ``adaptive_count``; then the other particles repeat the
    first n with a weight of 0. Output ``covariances``: (K, 6, 6) in row-major
    order: rotation vector (in radians), then position (in meters), in the
    world. Outputs ``tracked`` and ``detected``: (K,) 1 if the object has been
    detected, ever and at the last update, else 0. Output ``update_time``: of
    the last update (in seconds), -1 before it. Output ``detection_counts``:
    (K, 5) in row-major order: how many detections had which of the
    DETECTION_FATES. Output ``num_rejected``: (K,) how many in a row were
    outliers to all particles.

    Before an object is first detected, its estimate and particles are the
    nominal pose that the scene gives it, its covariance is that of the initial
    noise, and it takes no part in the physics of the others. Nothing is tracked
    as long as a joint has never had a finite value.

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
        joint_names: n names, to warn of joints.
        bounds: (2, 3) where objects may be detected; see add_measurement.

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
        joint_names: Sequence[str] = (),
        bounds: np.ndarray = ANYWHERE,
    ) -> None:
        super().__init__()
        config.ValidateOrThrow()
        self._config = config
        self._update = update
        self._object_names = tuple(object_names)
        self._on_update = on_update
        self._bounds = bounds
        self._positions_port = self.DeclareVectorInputPort(
            "joint_positions", num_joints
        )
        self._velocities_port = self.DeclareVectorInputPort(
            "joint_velocities", num_joints
        )
        self._measurement_port = self.DeclareAbstractInputPort(
            "dope_measurement", Value(DopeMeasurement())
        )
        self._memory = FilterMemory(
            self.DeclareDiscreteState,
            config=config,
            nominal_poses=nominal_poses,
            num_joints=num_joints,
        )
        # Contexts and processes of the models: no information is in them.
        self._scratch_index = self.DeclareCacheEntry(
            "scratch",
            ValueProducer(
                allocate=lambda: Value(
                    FilterScratch(
                        update, config.period, object_names, joint_names
                    )
                ),
                calc=ValueProducer.NoopCalc,
            ),
            {self.nothing_ticket()},
        ).cache_index()
        self._DeclareOutputs()
        self._DeclareEvents()

    def _DeclareOutputs(self) -> None:
        index = self._memory.index
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
        for port in "detected", "update_time", "detection_counts":
            self.DeclareStateOutputPort(port, index(port))
        self.DeclareStateOutputPort("num_rejected", index("num_rejected"))

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
        samples = self._memory.Samples(context.get_discrete_state())
        if np.isfinite(samples[-1, 0]) and samples[-1, 0] <= context.get_time():
            return
        sample = self._ReadJoints(context, samples[-1])
        self._memory.WriteSamples(values, np.tile(sample, (len(samples), 1)))
        self._memory.WriteUpdateTime(values, -1.0)

    def _Sample(self, context: Context, values: DiscreteValues) -> None:
        """Keeps joints and detections until the next update."""
        samples = self._memory.Samples(context.get_discrete_state())
        now = self._ReadJoints(context, samples[-1])
        samples = joint_samples.append_row(samples, now)
        self._memory.WriteSamples(values, samples)
        self._memory.WriteDetections(values, self._ReadDetections(context))

    def _Update(self, context: Context, values: DiscreteValues) -> None:
        start = wall_clock.perf_counter()
        self._Sample(context, values)
        scratch = self.get_cache_entry(self._scratch_index).Eval(context)
        last_time = self._memory.UpdateTime(context.get_discrete_state())
        self._memory.WriteUpdateTime(values, context.get_time())
        path = joint_samples.path_since(
            self._memory.Samples(values),
            last_time,
            bend=self._velocities_port.HasValue(context),
        )
        scratch.warnings.CheckJoints(path.positions[-1])
        if not np.all(np.isfinite(path.positions)):
            return
        detections = self._memory.Detections(values)
        state = self._memory.State(context)
        to_period = self._config.adaptive_count.to_period
        state = self._update.Update(
            state,
            path=path,
            detections=detections.unused(state.detection_times),
            scratch=scratch.ForUpdate(),
            most=scratch.pace.MaxParticles() if to_period else None,
        )
        self._memory.WriteState(values, state)
        scratch.warnings.CheckDetections(
            detections.detection_counts, state.num_rejected
        )
        seconds = wall_clock.perf_counter() - start
        scratch.pace.AddUpdate(seconds, int(state.num_used[0]))
        if self._on_update:
            self._on_update(seconds)

    def _ReadJoints(self, context: Context, last: np.ndarray) -> np.ndarray:
        """Returns the sample of now."""
        positions, velocities = self._positions_port.Eval(context), None
        if self._velocities_port.HasValue(context):
            velocities = self._velocities_port.Eval(context)
        time = context.get_time()
        return joint_samples.make_row(time, positions, velocities, last)

    def _ReadDetections(self, context: Context) -> RecentDetections:
        """Returns the stored detections with those of now."""
        stored = self._memory.Detections(context.get_discrete_state())
        if not self._measurement_port.HasValue(context):
            return stored
        return recent_detections.add_measurement(
            stored,
            EvalDopeMeasurement(self, context),
            object_names=self._object_names,
            now=context.get_time(),
            max_age=self._config.max_detection_age,
            bounds=self._bounds,
        )

    def _CalcEstimatedPoses(
        self, context: Context, output: AbstractValue
    ) -> None:
        poses = self._memory.State(context).estimates[0]
        output.set_value([rigid_transform(pose) for pose in poses])

    def _CalcEffectiveSampleSize(
        self, context: Context, output: BasicVector
    ) -> None:
        weights = self._memory.State(context).weights
        output.SetFromVector([effective_sample_size(weights)])

    def _CalcCovariances(self, context: Context, output: BasicVector) -> None:
        state, noise = self._memory.State(context), self._config.initial_noise
        output.SetFromVector(belief_covariances(state, noise).ravel())

    def _CalcTracked(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(
            1.0 * (self._memory.State(context).num_estimates > 0)
        )
