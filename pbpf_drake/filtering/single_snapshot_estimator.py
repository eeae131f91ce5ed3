"""Repetitive single-snapshot pose estimation, the baseline of Section 3."""

from collections.abc import Callable, Sequence
import time as wall_clock

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from pbpf_drake.dope_measurement import (
    Detection,
    DopeMeasurement,
    EvalDopeMeasurement,
)
from pbpf_drake.poses.pose_conversion import pose_array, rigid_transform


class SingleSnapshotEstimator(LeafSystem):
    """Takes the last detection of every object for its pose.

    It knows neither the robot nor physics: x̃_t = DOPE(z_t) (Section 3), and
    where an object isn't detected its latest pose is held (Section 6).

    .. pydrake_system::

        name: SingleSnapshotEstimator
        input_ports:
        - dope_measurement
        output_ports:
        - estimated_poses
        - tracked
        - detected
        - update_time

    Input ``dope_measurement``: a DopeMeasurement. A detection that is not
    newer than the one that is held is not used, nor is one that isn't finite;
    an object that the measurement lacks keeps its pose.

    Output ``estimated_poses``: List[RigidTransform], X_WO of K objects in the
    order of ``object_names``; the nominal pose before the first detection.

    Output ``tracked``: (K,), 1 once the object has been detected, 0 before.

    Output ``detected``: (K,), 1 if the last update used a new detection.

    Output ``update_time``: (1,), time of the last update (in seconds), -1
    before the first one.

    State: all of it is discrete. Events: an update every ``period``, the
    first one after ``period``, as in the particle filter.

    Args:
        object_names: names of the K tracked models.
        nominal_poses: (K, 7) their poses X_WO before the first detection:
            qw qx qy qz, x y z (in meters).
        period: time between two updates (in seconds).
        on_update: called after each update with its wall time (in seconds).

    Raises:
        ValueError: the shape of nominal_poses doesn't fit.
    """

    def __init__(
        self,
        *,
        object_names: Sequence[str],
        nominal_poses: np.ndarray,
        period: float = 0.16,
        on_update: Callable[[float], None] | None = None,
    ) -> None:
        super().__init__()
        if np.shape(nominal_poses) != (len(object_names), 7):
            raise ValueError(
                f"nominal_poses has the shape {np.shape(nominal_poses)}; "
                f"expected {(len(object_names), 7)}, for {list(object_names)}"
            )
        self._names = tuple(object_names)
        self._on_update = on_update
        self.DeclareAbstractInputPort(
            "dope_measurement", Value(DopeMeasurement())
        )
        # Quaternion w, x, y, z, then position, object after object.
        self._poses = self.DeclareDiscreteState(np.ravel(nominal_poses))
        self._stamps = self.DeclareDiscreteState(
            np.full(len(self._names), -np.inf)
        )
        self._tracked = self.DeclareDiscreteState(np.zeros(len(self._names)))
        self._detected = self.DeclareDiscreteState(np.zeros(len(self._names)))
        self._update_time = self.DeclareDiscreteState(np.array([-1.0]))
        self.DeclareAbstractOutputPort(
            "estimated_poses",
            alloc=lambda: Value([RigidTransform()] * len(object_names)),
            calc=self._CalcEstimatedPoses,
            prerequisites_of_calc={self.discrete_state_ticket(self._poses)},
        )
        self.DeclareStateOutputPort("tracked", self._tracked)
        self.DeclareStateOutputPort("detected", self._detected)
        self.DeclareStateOutputPort("update_time", self._update_time)
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=period, offset_sec=period, update=self._Update
        )

    def _CalcEstimatedPoses(self, context: Context, output: Value) -> None:
        poses = context.get_discrete_state(self._poses).value()
        output.set_value([rigid_transform(x) for x in poses.reshape(-1, 7)])

    def _Update(self, context: Context, state: DiscreteValues) -> None:
        start = wall_clock.perf_counter()
        measurement = EvalDopeMeasurement(self, context)
        poses = state.get_mutable_value(self._poses).reshape(-1, 7)
        stamps = state.get_mutable_value(self._stamps)
        detected = state.get_mutable_value(self._detected)
        for k, name in enumerate(self._names):
            detection = measurement.detections.get(name)
            detected[k] = _is_newer(detection, stamps[k])
            if detection is not None and detected[k]:
                poses[k] = pose_array(detection.X_WO)
                stamps[k] = detection.time
        tracked = state.get_mutable_value(self._tracked)
        tracked[:] = np.maximum(tracked, detected)
        state.get_mutable_value(self._update_time)[:] = context.get_time()
        if self._on_update:
            self._on_update(wall_clock.perf_counter() - start)


def _is_newer(detection: Detection | None, stamp: float) -> bool:
    """Tells if there is a finite detection that is newer than the stamp."""
    if detection is None or not np.isfinite(detection.time):
        return False
    finite = np.all(np.isfinite(detection.X_WO.GetAsMatrix34()))
    return bool(finite and detection.time > stamp)
