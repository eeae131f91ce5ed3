"""Says what an estimator would say that is never wrong."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from pbpf_drake.poses.pose_conversion import rigid_transform


class TruePoseSource(LeafSystem):
    """Says every period where objects truly are.

    .. pydrake_system::

        name: TruePoseSource
        input_ports:
        - state
        output_ports:
        - estimated_poses

    Input ``state``: positions, then velocities of the plant. Output
    ``estimated_poses``: list of K RigidTransform X_WO, as they were at the
    last update; before it, where the plant's default state has them.

    State: the poses, which are discrete. Events: an update every ``period``,
    the first one after ``period``, as in the particle filter.

    Args:
        plant: its objects are free bodies.
        objects: the K bodies.
        period: time between two updates (in seconds).
    """

    def __init__(
        self,
        *,
        plant: MultibodyPlant,
        objects: Sequence[BodyIndex],
        period: float,
    ) -> None:
        super().__init__()
        starts = [plant.get_body(b).floating_positions_start() for b in objects]
        self._rows = np.array(starts)[:, None] + np.arange(7)
        q = plant.GetPositions(plant.CreateDefaultContext())
        self._state_port = self.DeclareVectorInputPort(
            "state", plant.num_multibody_states()
        )
        self._poses = self.DeclareDiscreteState(q[self._rows].ravel())
        self.DeclareAbstractOutputPort(
            "estimated_poses",
            alloc=lambda: Value([RigidTransform()] * len(objects)),
            calc=self._CalcEstimatedPoses,
            prerequisites_of_calc={self.discrete_state_ticket(self._poses)},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=period, offset_sec=period, update=self._Update
        )

    def _Update(self, context: Context, values: DiscreteValues) -> None:
        q = self._state_port.Eval(context)[self._rows]
        values.get_mutable_value(self._poses)[:] = q.ravel()

    def _CalcEstimatedPoses(self, context: Context, output: Value) -> None:
        poses = context.get_discrete_state(self._poses).value().reshape(-1, 7)
        output.set_value([rigid_transform(pose) for pose in poses])
