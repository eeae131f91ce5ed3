"""Hulls with few corners, as each corner costs time in every contact."""

from itertools import product

import numpy as np
from scipy.spatial import ConvexHull

# The directions to a cube's corners, edges and faces.
_DIRECTIONS = np.array([d for d in product((-1, 0, 1), repeat=3) if any(d)])
# So many points at most are added at once.
_STEP = 32


def choose_hull_corners(points: np.ndarray, most: int) -> np.ndarray:
    """Returns which points to keep so that their hull is nearly that of all.

    It starts with those that reach the furthest in 26 directions. Then, again
    and again, it adds those that are the furthest outside of the hull so far.

    Args:
        points: (n, 3), not all in one plane.
        most: how many to keep at most, at least 26.

    Returns:
        The indices of the kept points, ascending. If there are no more than
        ``most`` corners of the hull, it has all of them.

    Raises:
        scipy.spatial.QhullError: the points are all in one plane, or nearly.
    """
    corners = np.sort(ConvexHull(points).vertices)
    if len(corners) <= most:
        return corners
    p = points[corners]
    kept = np.unique((p @ _DIRECTIONS.T).argmax(axis=0))
    while len(kept) < most:
        planes = ConvexHull(p[kept]).equations
        outside = planes[:, :3] @ p.T + planes[:, 3:]  # (faces, corners)
        furthest = np.argsort(-outside.max(axis=0), kind="stable")
        worst = np.unique(outside.argmax(axis=1))
        new = np.setdiff1d(worst, kept)
        if not len(new):
            break
        new = furthest[np.isin(furthest, new)][: min(_STEP, most - len(kept))]
        kept = np.union1d(kept, new)
    return corners[kept]
