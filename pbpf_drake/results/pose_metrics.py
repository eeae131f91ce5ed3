"""Errors of poses that know the object's shape: ADD, ADD-S, MSSD, AUC.

ADD and ADD-S are those of Hinterstoisser et al. (ACCV 2012) and of PoseCNN
(Xiang et al., RSS 2018), MSSD is that of the BOP challenge (Hodaň et al., ECCV
2020). All are computed in the frame of the true object, in which the estimated
pose X is D = X_ref⁻¹ X. Distances are the same in all frames.

Poses are (N, 7): unit quaternions w, x, y, z, then positions (in meters), all
in one frame. Points are (P, 3) in the object's frame (in meters).
"""

import numpy as np
from scipy.spatial import cKDTree

from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.poses.quaternions import (
    conjugate,
    from_rotation_vector,
    multiply,
    rotate,
)

# So many turns stand for all turns about an axis.
_NUM_TURNS = 64
# So many distances are computed at a time, so that a long log doesn't fill the
# memory.
_CHUNK = 300_000


def add_error(
    X: np.ndarray, X_ref: np.ndarray, points: np.ndarray
) -> np.ndarray:
    """Returns the mean distance of the points to themselves, (N,) (ADD)."""
    moved = _transform(_relative(X, X_ref), points)
    return np.mean(np.linalg.norm(moved - points, axis=-1), axis=-1)


def add_s_error(
    X: np.ndarray, X_ref: np.ndarray, points: np.ndarray
) -> np.ndarray:
    """Returns the mean distance to the nearest point, (N,) (ADD-S).

    For every point of the true object, the nearest one of the estimated
    object.
    """
    # In the estimated object's frame, all true points of all poses at once.
    true = _transform(_relative(X_ref, X), points)
    distances, _ = cKDTree(points).query(true.reshape(-1, 3))
    return np.mean(distances.reshape(true.shape[:-1]), axis=-1)


def mssd_error(
    X: np.ndarray,
    X_ref: np.ndarray,
    points: np.ndarray,
    symmetry: SymmetryConfig,
) -> np.ndarray:
    """Returns the largest distance of a point, (N,) (MSSD).

    It is the distance to the true object after the symmetric turn for which it
    is smallest.
    """
    D = _relative(X, X_ref)
    turns = symmetry.turns(_NUM_TURNS)
    turns = np.broadcast_to(turns, (len(D), *turns.shape))
    if symmetry.is_continuous():
        # The estimate's own turn about the axis is among those tried.
        along = D[:, 1:4] @ symmetry.unit_axis()
        own = 2 * np.arctan2(along, D[:, 0])[:, None] * symmetry.unit_axis()
        turns = multiply(from_rotation_vector(own)[:, None], turns)
    step = max(1, _CHUNK // (turns.shape[1] * len(points)))
    parts = [
        _largest_distances(D[i : i + step], turns[i : i + step], points)
        for i in range(0, len(D), step)
    ]
    return np.concatenate([np.empty(0), *parts])


def area_under_curve(errors: np.ndarray, limit: float = 0.1) -> float:
    """Returns the share of errors below a threshold, averaged over thresholds.

    The thresholds are all from 0 to the limit. 1 is perfect; an unknown error
    is above all of them.

    Args:
        errors: (...) distances (in meters), NaN where unknown.
        limit: the largest threshold (in meters).

    Returns:
        In [0, 1]; NaN if there are no errors.
    """
    errors = np.asarray(errors, dtype=float)
    known = np.where(np.isfinite(errors), errors, np.inf)
    if not known.size:
        return float("nan")
    return float(np.mean(1 - np.minimum(known, limit) / limit))


def _relative(X: np.ndarray, X_ref: np.ndarray) -> np.ndarray:
    """Returns X_ref⁻¹ X, (N, 7)."""
    inverse = conjugate(X_ref[:, :4])
    q = multiply(inverse, X[:, :4])
    p = rotate(inverse, X[:, 4:] - X_ref[:, 4:])
    return np.concatenate([q, p], axis=-1)


def _transform(D: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Returns all points moved by each pose, (N, P, 3)."""
    return rotate(D[:, None, :4], points) + D[:, None, 4:]


def _largest_distances(
    D: np.ndarray, turns: np.ndarray, points: np.ndarray
) -> np.ndarray:
    """Returns min over turns (N, S, 4) of max over points, (N,)."""
    moved = _transform(D, points)[:, None]
    turned = rotate(turns[:, :, None], points)
    return np.linalg.norm(moved - turned, axis=-1).max(axis=-1).min(axis=-1)
