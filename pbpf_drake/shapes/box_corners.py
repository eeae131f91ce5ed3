"""Corners and edges of boxes, always in the same order."""

import numpy as np

# On which side of the box's centre each corner is, along x, y and z, (8, 3).
_SIGNS = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
# How far the next corner along x, y and z is in this table.
_STEPS = (2, 4, 1)
# The corners at both ends of each edge, (12, 2).
_EDGES = np.array(
    [
        (corner, corner + step)
        for corner in np.lexsort(_SIGNS.T)
        for side, step in zip(_SIGNS[corner], _STEPS, strict=True)
        if side < 0
    ]
)


def box_corners(half_size: np.ndarray) -> np.ndarray:
    """Returns the 8 corners of boxes, in the frames of their centres.

    Args:
        half_size: (..., 3) half of the edges' lengths (in meters).

    Returns:
        (..., 8, 3), in meters.
    """
    return half_size[..., None, :] * _SIGNS


def box_edges(half_size: np.ndarray) -> np.ndarray:
    """Returns the 12 edges of a box from corner to corner, (12, 2, 3).

    Args:
        half_size: (3,) half of the edges' lengths (in meters).
    """
    return box_corners(half_size)[_EDGES]
