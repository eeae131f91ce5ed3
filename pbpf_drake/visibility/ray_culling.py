"""Which rays can't hit a shape, found with less work than casting them.

All rays start at one point, here the origin, and end at their targets. In doubt
a ray may hit, so that it changes nothing to leave out those that can't.
"""

import numpy as np

from pbpf_drake.visibility.ray_shapes import Interval

# A ray that comes this near may hit. It is far more than rounding errors (in
# meters).
_SLACK = 1e-6


def coordinates(vectors: np.ndarray) -> np.ndarray:
    """Returns (3, ...) of vectors (..., 3): it is faster to calculate with."""
    return np.ascontiguousarray(np.moveaxis(vectors, -1, 0))


def along(d: np.ndarray, n: np.ndarray) -> np.ndarray:
    """Returns n · d of vectors d (3, ...) and n (..., 3), (...).

    Unlike a matrix product, it has the same bits however many vectors there
    are.
    """
    return d[0] * n[..., 0] + d[1] * n[..., 1] + d[2] * n[..., 2]


def may_hit_balls(
    ways: np.ndarray, p_OG: np.ndarray, radii: np.ndarray
) -> np.ndarray:
    """Returns whether any ray of a group may hit a ball, (G, N).

    All targets of a group are within ρ of their middle, so all its rays are
    within ρ of the line to there.

    Args:
        ways: (3, N, R) from the origin to the targets of N groups.
        p_OG: (G, 1 or N, 3) from the origin to the centres of G balls.
        radii: (G, 1 or N) of the balls.
    """
    low, high = ways.min(axis=-1).T, ways.max(axis=-1).T
    middle = (low + high) / 2
    rho = np.linalg.norm(high - low, axis=-1) / 2
    length = np.einsum("ni,ni->n", middle, middle)
    u = (p_OG * middle).sum(axis=-1) / np.maximum(length, 1e-300)
    beside = p_OG - np.clip(u, 0.0, 1.0)[..., None] * middle
    reach = radii + rho + _SLACK
    return np.einsum("gni,gni->gn", beside, beside) <= reach**2


def may_enter_box(
    d: np.ndarray, o: np.ndarray, R_WG: np.ndarray, bounds: Interval
) -> np.ndarray:
    """Returns which rays get past the side of a box that faces them, (N,).

    The others end before they could meet anything in the box. Where the rays
    start in the box, all may hit.

    Args:
        d: (3, N) of the rays, in the world.
        o: (3,) where they start, in the box's frame G.
        R_WG: (3, 3) the rotation of G.
        bounds: the lowest and the highest coordinates of the box in G.
    """
    low, high = bounds
    outside = np.stack([low - o, o - high])
    side, axis = np.unravel_index(np.argmax(outside), outside.shape)
    if outside[side, axis] <= 0:
        return np.ones(d.shape[1], dtype=bool)
    n = R_WG[:, axis] if side else -R_WG[:, axis]
    return along(d, n) <= _SLACK - outside[side, axis]


def may_hit_ball(d: np.ndarray, p_OG: np.ndarray, radius: float) -> np.ndarray:
    """Returns which rays from 0 along d (3, N) may hit a ball, (N,)."""
    distance = float(np.linalg.norm(p_OG))
    if distance <= radius:
        return np.ones(d.shape[1], dtype=bool)
    # A ray that touches the ball from outside has come this far.
    tangent = np.sqrt(distance**2 - radius**2) - _SLACK
    length = np.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
    return along(d, p_OG) >= tangent * length
