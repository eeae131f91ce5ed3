"""Gaussian noise on poses: ε of Section 4.1, and the first particles.

Poses are arrays (..., 7): qw qx qy qz (a unit quaternion), x y z (in meters).
"""

import numpy as np

from pbpf_drake import quaternions
from pbpf_drake.particle_filter_config import PoseStddev


def random_rotation_vectors(
    shape: tuple[int, ...], stddev: float, rng: np.random.Generator
) -> np.ndarray:
    """Returns (*shape, 3): angles ~ N(0, stddev²) about uniform axes."""
    axes = rng.standard_normal((*shape, 3))
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    return stddev * rng.standard_normal((*shape, 1)) * axes


def perturb_poses(
    poses: np.ndarray, dp: np.ndarray, dr: np.ndarray
) -> np.ndarray:
    """Returns poses (..., 7) moved by dp and turned about their own origin.

    Args:
        poses: (..., 7).
        dp: (..., 3) shift in the world (in meters).
        dr: (..., 3) rotation vector in the world (in radians).
    """
    q = quaternions.multiply(quaternions.from_rotation_vector(dr), poses[..., :4])
    return np.concatenate(
        [quaternions.normalize(q), poses[..., 4:] + dp], axis=-1
    )


def add_process_noise(
    poses: np.ndarray,
    stddev: PoseStddev,
    rng: np.random.Generator,
    supports: np.ndarray | None = None,
) -> np.ndarray:
    """Returns poses + ε, ε ~ N(0, σ_f²) (Section 4.1).

    Of what stands on a support, only the part of the noise counts that slides
    it there and turns it about the normal.

    Args:
        poses: (..., 7).
        stddev: of each axis of the position, and of the angle about an axis
            drawn uniformly.
        rng: where the numbers come from.
        supports: (..., 3) unit normals, or zeros for what stands on nothing.
    """
    shape = poses.shape[:-1]
    dp = stddev.position * rng.standard_normal((*shape, 3))
    dr = random_rotation_vectors(shape, stddev.rotation, rng)
    if supports is not None:
        stands = np.any(supports, axis=-1, keepdims=True)
        dp = dp - supports * np.sum(dp * supports, axis=-1, keepdims=True)
        normal = supports * np.sum(dr * supports, axis=-1, keepdims=True)
        dr = np.where(stands, normal, dr)
    return perturb_poses(poses, dp, dr)


def sample_initial_poses(
    num_particles: int,
    pose: np.ndarray,
    stddev: PoseStddev,
    rng: np.random.Generator,
) -> np.ndarray:
    """Returns (M, 7) poses around the first detection (Section 6).

    The spread is horizontal, σ/√2 along each axis, as in the authors' code:
    the paper gives one number for the position, and what stands on a table
    can't be 0.16 m above or below it.

    Args:
        num_particles: M.
        pose: (7,), the detection X_WO.
        stddev: of the horizontal distance, and of the rotation angle.
        rng: where the numbers come from.
    """
    dp = np.zeros((num_particles, 3))
    dp[:, :2] = stddev.position / np.sqrt(2) * rng.standard_normal(
        (num_particles, 2)
    )
    dr = random_rotation_vectors((num_particles,), stddev.rotation, rng)
    return perturb_poses(np.tile(pose, (num_particles, 1)), dp, dr)
