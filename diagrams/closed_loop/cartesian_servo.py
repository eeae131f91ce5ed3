"""Moves a robot's joints so that its fingertip is where it has to be.

This is differential inverse kinematics: it finds the joint velocities with
which the fingertip moves to the wanted place while the hand keeps its
orientation.
"""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    Frame,
    JacobianWrtVariable,
    ModelInstanceIndex,
)
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from pbpf_drake.truth.push_path import ActuatedJoints

# Damps the pseudo-inverse, so that joints stay slow near a singularity.
_DAMPING = 1e-2


class CartesianServo(LeafSystem):
    """Turns positions of a fingertip into commands for joints.

    .. pydrake_system::

        name: CartesianServo
        input_ports:
        - fingertip_position
        output_ports:
        - desired_state

    Input ``fingertip_position``: (3,) in the world (in meters). Output
    ``desired_state``: (2n,) positions, then velocities of the robot's joints,
    in the order of its actuators, as the plant's port for them asks for.

    State: the output, which is discrete. Events: an update every ``period``.

    Args:
        plant: finalized; the robot starts at its default positions, and the
            hand keeps the orientation that it has there.
        robot: the robot's model instance.
        hand: a frame of the robot.
        fingertip: (3,) in the hand's frame (in meters).
        period: time between two commands (in seconds).
    """

    def __init__(
        self,
        *,
        plant: MultibodyPlant,
        robot: ModelInstanceIndex,
        hand: Frame,
        fingertip: np.ndarray,
        period: float = 0.01,
    ) -> None:
        super().__init__()
        self._plant, self._hand, self._period = plant, hand, period
        self._tip = np.asarray(fingertip)
        joints = [plant.get_joint(j) for j in ActuatedJoints(plant, robot)]
        self._q_rows = [j.position_start() for j in joints]
        self._v_rows = [j.velocity_start() for j in joints]
        # Only work space: each update sets all that it reads.
        self._work = plant.CreateDefaultContext()
        q = plant.GetPositions(self._work)[self._q_rows]
        self._R_WH = hand.CalcPoseInWorld(self._work).rotation()
        self._position = self.DeclareVectorInputPort("fingertip_position", 3)
        self._command = self.DeclareDiscreteState([*q, *np.zeros(len(q))])
        self.DeclareStateOutputPort("desired_state", self._command)
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=period, offset_sec=0.0, update=self._Update
        )

    def FingertipAtStart(self) -> np.ndarray:
        """Returns where the fingertip is at first, (3,) (in meters)."""
        work = self._plant.CreateDefaultContext()
        return self._hand.CalcPoseInWorld(work) @ self._tip

    def _Update(self, context: Context, values: DiscreteValues) -> None:
        command = values.get_mutable_value(self._command)
        n = len(self._q_rows)
        positions = self._plant.GetPositions(self._work)
        positions[self._q_rows] = command[:n]
        self._plant.SetPositions(self._work, positions)
        J = self._plant.CalcJacobianSpatialVelocity(
            context=self._work,
            with_respect_to=JacobianWrtVariable.kV,
            frame_B=self._hand,
            p_BoBp_B=self._tip,
            frame_A=self._plant.world_frame(),
            frame_E=self._plant.world_frame(),
        )[:, self._v_rows]
        V_WT = self._Wanted(self._position.Eval(context)).get_coeffs()
        square = J @ J.T + _DAMPING**2 * np.eye(6)
        velocity = J.T @ np.linalg.solve(square, V_WT)
        command[n:] = velocity
        command[:n] += velocity * self._period

    def _Wanted(self, p_WT: np.ndarray) -> SpatialVelocity:
        """Returns the velocity of the tip that leads there in one period."""
        X_WH: RigidTransform = self._hand.CalcPoseInWorld(self._work)
        turn = (self._R_WH @ X_WH.rotation().inverse()).ToAngleAxis()
        return SpatialVelocity(
            w=turn.angle() * turn.axis() / self._period,
            v=(p_WT - X_WH @ self._tip) / self._period,
        )
