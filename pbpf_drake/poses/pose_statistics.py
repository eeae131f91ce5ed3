"""Mean and covariance of weighted poses.

Poses are arrays (..., 7): qw qx qy qz (a unit quaternion), x y z (in meters).
"""

import numpy as np

from pbpf_drake.poses import quaternions


def mean_quaternion(q: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Returns Markley's mean of rotations, (..., 4), with w ≥ 0.

    It is the eigenvector of the largest eigenvalue of Σ w q qᵀ, which doesn't
    depend on the signs of the quaternions (Markley et al., Averaging
    Quaternions, 2007).

    Args:
        q: (M, ..., 4).
        weights: (M,) that sum to 1.
    """
    moment = np.einsum("m,m...i,m...j->...ij", weights, q, q)
    mean = np.linalg.eigh(moment)[1][..., :, -1]
    return np.where(mean[..., :1] < 0, -mean, mean)


def mean_pose(poses: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Returns the mean, (..., 7), of poses (M, ..., 7) (Section 4).

    Args:
        poses: (M, ..., 7).
        weights: (M,) that sum to 1.
    """
    p = np.einsum("m,m...i->...i", weights, poses[..., 4:])
    return np.concatenate(
        [mean_quaternion(poses[..., :4], weights), p], axis=-1
    )


def pose_covariance(
    poses: np.ndarray, weights: np.ndarray, mean: np.ndarray
) -> np.ndarray:
    """Returns the covariance (..., 6, 6) of poses about their mean.

    The rows are those of Drake's spatial vectors: first the rotation vector
    of R_WO R_Wmeanᵀ (in radians), then the position (in meters), both
    expressed in the world.

    Args:
        poses: (M, ..., 7).
        weights: (M,) that sum to 1.
        mean: (..., 7), as from ``mean_pose``.
    """
    turn = quaternions.multiply(
        poses[..., :4], quaternions.conjugate(mean[..., :4])
    )
    deviation = np.concatenate(
        [
            quaternions.to_rotation_vector(turn),
            poses[..., 4:] - mean[..., 4:],
        ],
        axis=-1,
    )
    return np.einsum("m,m...i,m...j->...ij", weights, deviation, deviation)
