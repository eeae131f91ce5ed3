"""A system that plays recorded ground truth."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, LeafSystem

from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.log.pose_interpolation import interpolate_poses


class GroundTruthLogSource(LeafSystem):
    """Plays the recorded true poses of K objects.

    .. pydrake_system::

        name: GroundTruthLogSource
        output_ports:
        - ground_truth_poses

    Output ``ground_truth_poses``: List[RigidTransform] of length K: X_WO of
    each object at the context's time, interpolated as ``interpolate_poses``
    says. Before the record starts and after it ends it is the pose there.

    The context's time 0 is the log's start.
    """

    def __init__(
        self,
        *,
        records: Mapping[str, PoseRecord],
        object_names: Sequence[str],
    ):
        """Makes the system.

        Args:
            records: recorded motions by name of the tracked model.
            object_names: K names, in the order of the output.

        Raises:
            ValueError: an object has no record. Play only those that have.
        """
        super().__init__()
        missing = [name for name in object_names if name not in records]
        if missing:
            raise ValueError(
                f"object_names has {missing}, but ground truth is known only "
                f"of {list(records)}"
            )
        self._records = [records[name] for name in object_names]
        self.DeclareAbstractOutputPort(
            name="ground_truth_poses",
            alloc=lambda: Value([RigidTransform()] * len(object_names)),
            calc=self._CalcPoses,
            prerequisites_of_calc={self.time_ticket()},
        )

    def _CalcPoses(self, context: Context, output: AbstractValue) -> None:
        output.set_value([self._Pose(r, context) for r in self._records])

    def _Pose(self, record: PoseRecord, context: Context) -> RigidTransform:
        q, p = interpolate_poses(record, np.array([context.get_time()]))
        return RigidTransform(quaternion=Quaternion(*q[0].tolist()), p=p[0])
