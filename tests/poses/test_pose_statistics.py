import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pbpf_drake.poses import quaternions
from pbpf_drake.poses.pose_statistics import (
    mean_pose,
    mean_quaternion,
    pose_covariance,
)


def test_mean_of_a_symmetric_pair_is_its_middle():
    turn = np.array([0.0, 0.0, 0.4])
    q = quaternions.from_rotation_vector(np.array([turn, -turn]))
    np.testing.assert_allclose(
        mean_quaternion(q, np.array([0.5, 0.5])), [1, 0, 0, 0], atol=1e-15
    )


def test_mean_does_not_depend_on_signs():
    rng = np.random.default_rng(0)
    q = quaternions.from_rotation_vector(0.5 * rng.standard_normal((9, 3)))
    signs = rng.choice([-1, 1], (9, 1))
    weights = rng.dirichlet(np.ones(9))
    np.testing.assert_allclose(
        mean_quaternion(q, weights), mean_quaternion(signs * q, weights)
    )


def test_mean_agrees_with_scipys_weighted_mean():
    rng = np.random.default_rng(1)
    q = quaternions.from_rotation_vector(rng.standard_normal((30, 3)))
    weights = rng.dirichlet(np.ones(30))
    expected = Rotation.from_quat(q, scalar_first=True).mean(weights)
    assert (
        quaternions.angle_between(
            mean_quaternion(q, weights), expected.as_quat(scalar_first=True)
        )
        < 1e-7
    )


def test_mean_pose_of_several_objects_is_each_ones_mean():
    rng = np.random.default_rng(2)
    poses = rng.standard_normal((20, 3, 7))
    poses[..., :4] = quaternions.normalize(poses[..., :4])
    weights = rng.dirichlet(np.ones(20))
    together = mean_pose(poses, weights)
    for k in range(3):
        np.testing.assert_allclose(
            together[k], mean_pose(poses[:, k], weights), atol=1e-12
        )
        np.testing.assert_allclose(
            together[k, 4:], weights @ poses[:, k, 4:], atol=1e-12
        )


def test_covariance_is_that_of_the_samples():
    rng = np.random.default_rng(3)
    factor = np.diag([0.02, 0.03, 0.01, 0.1, 0.2, 0.3])
    factor[4, 0] = 0.1  # Position and rotation are correlated.
    samples = rng.standard_normal((200_000, 6)) @ factor.T
    q_mean = quaternions.from_rotation_vector(np.array([0.3, -0.5, 0.2]))
    poses = np.concatenate(
        [
            quaternions.multiply(
                quaternions.from_rotation_vector(samples[:, :3]), q_mean
            ),
            samples[:, 3:] + [1.0, 2.0, 3.0],
        ],
        axis=1,
    )
    weights = np.full(len(poses), 1 / len(poses))
    mean = mean_pose(poses, weights)
    covariance = pose_covariance(poses, weights, mean)
    assert covariance == pytest.approx(factor @ factor.T, abs=5e-4)
