"""What is drawn once per run of the truth."""

from dataclasses import dataclass

import numpy as np

from pbpf_drake.config.recording_config import RecordingConfig
from pbpf_drake.truth.push_path import draw_offsets


@dataclass(frozen=True)
class TruthParameters:
    """What differs from run to run.

    Attributes:
        mass_scale: (K,) the objects' true masses over those of their models.
        friction: Coulomb friction between objects and everything fixed.
        robot_friction: Coulomb friction of the robot's surface.
        offsets: (W, 3) how far off the path's waypoints are (in meters).
        starts: (K, 3) how far from the scene's own pose each object starts: x
            and y (in meters), then the angle about the vertical (in radians).
    """

    mass_scale: np.ndarray
    friction: float
    robot_friction: float
    offsets: np.ndarray
    starts: np.ndarray


def draw_truth_parameters(
    config: RecordingConfig, num_objects: int, rng: np.random.Generator
) -> TruthParameters:
    """Draws the true parameters of a run.

    Args:
        config: what they are drawn from.
        num_objects: K.
        rng: where the random numbers come from.
    """
    stddev = config.start_stddev
    return TruthParameters(
        mass_scale=rng.uniform(
            config.mass_scale.min, config.mass_scale.max, num_objects
        ),
        friction=rng.uniform(config.friction.min, config.friction.max),
        robot_friction=rng.uniform(
            config.robot_friction.min, config.robot_friction.max
        ),
        offsets=draw_offsets(config.path, rng),
        starts=rng.standard_normal((num_objects, 3))
        * [stddev.position, stddev.position, stddev.rotation],
    )
