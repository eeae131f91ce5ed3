"""An object that slides on the table, for the tests of all engines."""

import numpy as np
from numpy.typing import ArrayLike

from pbpf_drake.control_path import ControlPath
from pbpf_drake.motion_model import MotionInput
from pbpf_drake.prediction_model import PredictionModel

GRAVITY = 9.81
PERIOD = 0.16


def resting_robot(model: PredictionModel) -> np.ndarray:
    """Returns the scene's own joint positions (n,), where nothing is near."""
    plant = model.diagram.plant()
    positions = plant.GetPositions(plant.CreateDefaultContext())
    return positions[model.robot_q]


def slide(
    model: PredictionModel, velocity: ArrayLike, num_particles: int
) -> MotionInput:
    """Returns objects at their nominal poses that slide on.

    Args:
        model: of a scene whose robot touches nothing.
        velocity: (3,) or (K, 3) of the objects (in m/s).
        num_particles: M, all alike.
    """
    poses = np.tile(model.nominal_poses, (num_particles, 1, 1))
    # A little into the table, as an object at rest is.
    poses[..., 6] -= 1e-5
    velocities = np.zeros((*poses.shape[:2], 6))
    velocities[..., 3:] = velocity
    num_objects = poses.shape[1]
    return MotionInput(
        poses=poses,
        velocities=velocities,
        active=np.ones(num_objects, dtype=bool),
        path=ControlPath(
            np.array([0.0, PERIOD]), np.tile(resting_robot(model), (2, 1))
        ),
        estimates=np.tile(model.nominal_poses, (2, 1, 1)),
        num_estimates=np.full(num_objects, 2.0),
        step=1,
    )
