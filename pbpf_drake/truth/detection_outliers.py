"""Detections that are far off, as of an object that is partly hidden.

What the real traces of the authors' detector show, and what is drawn here:

- Good positions and outliers follow each other as independent draws do: they
  change places 20 times at 47 steps, where 22 are expected.
- Position and rotation are outliers independently of each other: 12 of 29 boxes
  that were seen turned over were where the box was.
- The nearer the box is to being lost, the more rotations are outliers and the
  longer the distances are. (That there are more positions as well is simpler,
  and not seen in all traces.)
"""

import numpy as np

from pbpf_drake.config.recording_config import DetectorConfig


def draw_directions(rng: np.random.Generator) -> np.ndarray:
    """Draws a unit vector for a rotation and one for a position, (2, 3)."""
    directions = rng.standard_normal((2, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def draw_outlier_error(
    occlusion: float, config: DetectorConfig, rng: np.random.Generator
) -> np.ndarray:
    """Draws by how much an outlier is off, (6,), zeros where it isn't one.

    The random numbers are the same whatever the occlusion: with more of it,
    what was an outlier still is one, in the same direction.

    Args:
        occlusion: from 0 at the clear visibility to 1 at the hidden one.
        config: the chance of an outlier, and how far off it is.
        rng: where the numbers are drawn from.

    Returns:
        A rotation vector (in radians), then a translation (in meters).
    """
    is_off = rng.uniform(size=2) < config.outlier_chance * occlusion
    u, w = rng.uniform(size=2)
    directions = draw_directions(rng)
    angle, distance = config.outlier_rotation, config.outlier_position
    # The farther half of how far it gets with this occlusion.
    way = np.sqrt(occlusion) * (1 + w) / 2
    sizes = np.array(
        [
            angle.min + u * (angle.max - angle.min),
            distance.min * (distance.max / distance.min) ** way,
        ]
    )
    return ((is_off * sizes)[:, np.newaxis] * directions).ravel()
