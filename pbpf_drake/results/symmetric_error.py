"""Errors of rotations up to the turns that an object looks the same after."""

import numpy as np

from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.poses.quaternions import angle_between, conjugate, multiply


def symmetric_rotation_error(
    q: np.ndarray, q_ref: np.ndarray, symmetry: SymmetryConfig
) -> np.ndarray:
    """Returns the smallest angle to a rotation that looks like the true one.

    Args:
        q: (..., 4) estimated unit quaternions w, x, y, z.
        q_ref: (..., 4) true ones, in the same frame.
        symmetry: of the object.

    Returns:
        (...), in [0, pi] (in radians).
    """
    d = multiply(conjugate(q_ref), q)
    if symmetry.is_continuous():
        along = d[..., 1:] @ symmetry.unit_axis()
        # The rest of d, without its turn about the axis.
        across = np.linalg.norm(
            np.cross(d[..., 1:], symmetry.unit_axis()), axis=-1
        )
        return 2 * np.arctan2(across, np.hypot(d[..., 0], along))
    # The turns are countable here, and the number given doesn't matter.
    turns = symmetry.turns(1)
    return np.min(angle_between(d[..., None, :], turns), axis=-1)
