"""Detections that are far off because the object is partly hidden.

What is drawn here is what the recorded errors of the authors' detector show:

- Whether a position is an outlier doesn't depend on the one before. In 47 steps
  from one detection to the next, outliers and good positions took turns 20
  times, where 22 are expected of independent draws.
- Position and rotation are outliers independently of each other: of 29 boxes
  that were seen turned over, 12 were in the right place.
- The nearer the box is to being lost, the more rotations are outliers, and the
  farther off positions are. (Here, more positions are outliers as well. That is
  simpler, but not all recordings show it.)
"""

import numpy as np

from pbpf_drake.config.detector_config import DetectorConfig


def draw_directions(rng: np.random.Generator) -> np.ndarray:
    """Draws a unit vector for a rotation and one for a position, (2, 3)."""
    directions = rng.standard_normal((2, 3))
    return directions / np.linalg.norm(directions, axis=1, keepdims=True)


def draw_outlier_error(
    occlusion: float, config: DetectorConfig, rng: np.random.Generator
) -> np.ndarray:
    """Draws how far off an outlier is, (6,): zeros where there is none.

    The same random numbers are drawn whatever the occlusion is. So an outlier
    would also be one, in the same direction, if more of the object were hidden.

    Args:
        occlusion: from 0 at the clear visibility to 1 at the hidden one.
        config: the chance of an outlier, and how far off it is.
        rng: where the random numbers come from.

    Returns:
        A rotation vector (in radians), then a translation (in meters).
    """
    is_off = rng.uniform(size=2) < config.outlier_chance * occlusion
    u, w = rng.uniform(size=2)
    directions = draw_directions(rng)
    angle, distance = config.outlier_rotation, config.outlier_position
    # From half to all of how far it can get with this occlusion, on a
    # logarithmic scale from the least distance (0) to the largest (1).
    way = np.sqrt(occlusion) * (1 + w) / 2
    sizes = np.array(
        [
            angle.min + u * (angle.max - angle.min),
            distance.min * (distance.max / distance.min) ** way,
        ]
    )
    return ((is_off * sizes)[:, np.newaxis] * directions).ravel()
