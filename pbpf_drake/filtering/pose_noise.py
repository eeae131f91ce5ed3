"""Gaussian noise on poses: ε of Section 4.1, and the first particles.

Poses are arrays (..., 7): qw qx qy qz (a unit quaternion), x y z (in meters).
"""

import numpy as np

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.poses import quaternions


def perturb_poses(
    poses: np.ndarray, dp: np.ndarray, dr: np.ndarray
) -> np.ndarray:
    """Returns poses (..., 7) moved by dp and turned about their own origin.

    Args:
        poses: (..., 7).
        dp: (..., 3) shift in the world (in meters).
        dr: (..., 3) rotation vector in the world (in radians).
    """
    q = quaternions.multiply(
        quaternions.from_rotation_vector(dr), poses[..., :4]
    )
    return np.concatenate(
        [quaternions.normalize(q), poses[..., 4:] + dp], axis=-1
    )


def add_process_noise(
    poses: np.ndarray,
    stddev: PoseStddev,
    rng: np.random.Generator,
    supports: np.ndarray,
) -> np.ndarray:
    """Returns poses + ε, ε ~ N(0, σ_f²) (Section 4.1).

    Of the noise of what stands on a support, what would lift or tilt it is
    left out.

    Args:
        poses: (..., 7).
        stddev: of the distance (its root mean square in space: σ/√3 along
            each axis), and of the angle, about any axis.
        rng: where the numbers come from.
        supports: (..., 3) unit normals, or zeros for what stands on
            nothing.
    """
    shape = poses.shape[:-1]
    dp = rng.standard_normal((*shape, 3)) * stddev.position / np.sqrt(3)
    dr = _random_axes(shape, rng) * rng.standard_normal((*shape, 1))
    dr *= stddev.rotation
    stands = np.any(supports, axis=-1, keepdims=True)
    upwards = supports * np.sum(dp * supports, axis=-1, keepdims=True)
    turning = supports * np.sum(dr * supports, axis=-1, keepdims=True)
    return perturb_poses(poses, dp - upwards, np.where(stands, turning, dr))


def sample_around(
    pose: np.ndarray,
    num_samples: int,
    stddev: PoseStddev,
    rng: np.random.Generator,
) -> np.ndarray:
    """Returns (n, 7) poses around the first detection (Section 6).

    The spread is horizontal, σ/√2 along each axis, as in the authors' code:
    the paper gives one number for the position, and what stands on a table
    can't be 0.16 m above or below it.

    Args:
        pose: (7,), the detection X_WO.
        num_samples: n.
        stddev: of the horizontal distance, and of the rotation angle.
        rng: where the numbers come from.
    """
    dp = np.zeros((num_samples, 3))
    dp[:, :2] = rng.standard_normal((num_samples, 2))
    dp *= stddev.position / np.sqrt(2)
    axes = _random_axes((num_samples,), rng)
    angles = stddev.rotation * rng.standard_normal((num_samples, 1))
    return perturb_poses(np.tile(pose, (num_samples, 1)), dp, angles * axes)


def _random_axes(
    shape: tuple[int, ...], rng: np.random.Generator
) -> np.ndarray:
    """Returns unit vectors (*shape, 3), spread uniformly."""
    axes = rng.standard_normal((*shape, 3))
    return axes / np.linalg.norm(axes, axis=-1, keepdims=True)
