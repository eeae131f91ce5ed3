"""One push to do: where the object is, and where it has to go."""

from dataclasses import dataclass

import numpy as np

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.truth.truth_parameters import (
    TruthParameters,
    draw_truth_parameters,
)

# Where goals are: behind the obstacle, x and y (in meters).
_GOAL_LOWER, _GOAL_UPPER = (0.40, 0.20), (0.52, 0.36)
# Where the object starts: x, y (in meters) and yaw (in radians).
_START_LOWER, _START_UPPER = (0.42, -0.13, -0.5), (0.48, -0.07, 0.5)


@dataclass(frozen=True)
class PushTask:
    """What is drawn at random for one run.

    Attributes:
        goal: (2,) where the object's centre has to go (in meters).
        start: (3,) where it is at first: x, y (in meters), yaw (in radians).
        parameters: friction and masses.
        seed: of the detector and of the filter.
    """

    goal: np.ndarray
    start: np.ndarray
    parameters: TruthParameters
    seed: int


def draw_task(scene: Scene, seed: int) -> PushTask:
    """Draws a goal behind the obstacle, and where the object is at first."""
    rng = np.random.default_rng(seed)
    return PushTask(
        goal=rng.uniform(_GOAL_LOWER, _GOAL_UPPER),
        start=rng.uniform(_START_LOWER, _START_UPPER),
        parameters=draw_truth_parameters(
            scene.recording, len(scene.tracked), rng
        ),
        seed=seed,
    )
