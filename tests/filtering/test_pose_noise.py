import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RotationMatrix
import pytest

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.filtering.pose_noise import (
    add_process_noise,
    perturb_poses,
    sample_around,
)
from pbpf_drake.poses import quaternions
from pbpf_drake.poses.pose_conversion import pose_array, rigid_transform

N = 40_000
STDDEV = PoseStddev(position=0.05, rotation=0.3)
POSE = np.array([0.5, 0.5, -0.1, 0.7, 0.4, -0.2, 0.1])
POSE[:4] /= np.linalg.norm(POSE[:4])
TILTED = np.array([2.0, -1.0, 2.0]) / 3


def _noisy(supports, stddev=STDDEV):
    poses = np.tile(POSE, (N, 1))
    rng = np.random.default_rng(1)
    return add_process_noise(poses, stddev, rng, np.asarray(supports))


def _shift_and_turn(poses):
    q = quaternions.multiply(poses[:, :4], quaternions.conjugate(POSE[:4]))
    return poses[:, 4:] - POSE[4:], quaternions.to_rotation_vector(q)


def _rms(x):
    return np.sqrt(np.mean(np.sum(x * x, axis=-1)))


def test_a_perturbed_pose_is_turned_about_its_own_origin_in_the_world():
    angle, axis = 0.7, np.array([0.6, 0.0, 0.8])
    turned = perturb_poses(POSE, np.array([0.1, 0.2, 0.3]), angle * axis)
    X_WO = rigid_transform(POSE)
    R = RotationMatrix(AngleAxis(angle=angle, axis=axis)) @ X_WO.rotation()
    result = rigid_transform(turned)
    np.testing.assert_allclose(
        result.rotation().matrix(), R.matrix(), atol=1e-14
    )
    np.testing.assert_allclose(
        result.translation(), POSE[4:] + [0.1, 0.2, 0.3], atol=1e-15
    )
    np.testing.assert_allclose(np.linalg.norm(turned[:4]), 1, atol=1e-15)


def test_poses_and_arrays_of_any_shape_are_perturbed_one_by_one():
    rng = np.random.default_rng(2)
    poses = np.tile(POSE, (3, 2, 1)) + rng.standard_normal((3, 2, 7))
    poses[..., :4] = quaternions.normalize(poses[..., :4])
    dp, dr = rng.standard_normal((2, 3, 2, 3))
    together = perturb_poses(poses, dp, dr)
    for index in np.ndindex(3, 2):
        alone = perturb_poses(poses[index], dp[index], dr[index])
        np.testing.assert_allclose(together[index], alone, atol=1e-15)


def test_noise_in_space_has_the_distance_and_the_angle_of_its_deviation():
    dp, dr = _shift_and_turn(_noisy(np.zeros((N, 3))))
    assert _rms(dp) == pytest.approx(STDDEV.position, rel=0.02)
    assert _rms(dr) == pytest.approx(STDDEV.rotation, rel=0.02)
    for x, variance in (
        (dp, STDDEV.position**2 / 3),
        (dr, STDDEV.rotation**2 / 3),
    ):
        # Centered, and the same in all directions.
        np.testing.assert_allclose(
            np.mean(x, axis=0), 0, atol=4 * np.sqrt(variance / N)
        )
        np.testing.assert_allclose(
            x.T @ x / N, variance * np.eye(3), atol=0.04 * variance
        )


@pytest.mark.parametrize("normal", [np.array([0.0, 0.0, 1.0]), TILTED])
def test_noise_on_a_support_slides_along_it_and_turns_about_its_normal(normal):
    dp, dr = _shift_and_turn(_noisy(np.tile(normal, (N, 1))))
    np.testing.assert_allclose(dp @ normal, 0, atol=1e-15)
    np.testing.assert_allclose(np.cross(dr, normal), 0, atol=1e-14)
    # Two of three directions, and one of three, are left.
    assert _rms(dp) == pytest.approx(STDDEV.position * np.sqrt(2 / 3), rel=0.02)
    assert _rms(dr) == pytest.approx(STDDEV.rotation / np.sqrt(3), rel=0.02)
    across = np.cross(normal, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    for axis in (across, np.cross(normal, across)):
        stddev = np.std(dp @ axis)
        assert stddev == pytest.approx(STDDEV.position / np.sqrt(3), rel=0.02)


def test_every_particle_has_the_noise_of_its_own_support():
    supports = np.zeros((N, 3))
    supports[::2] = TILTED
    dp, dr = _shift_and_turn(_noisy(supports))
    np.testing.assert_allclose(dp[::2] @ TILTED, 0, atol=1e-15)
    np.testing.assert_allclose(np.cross(dr[::2], TILTED), 0, atol=1e-14)
    free = np.std(dp[1::2] @ TILTED)
    assert free == pytest.approx(STDDEV.position / np.sqrt(3), rel=0.03)


def test_no_deviation_is_no_noise():
    for normal in (np.zeros(3), TILTED):
        poses = _noisy(np.tile(normal, (N, 1)), PoseStddev())
        np.testing.assert_allclose(poses, np.tile(POSE, (N, 1)), atol=1e-15)


def test_noise_leaves_its_input_as_it_is():
    poses, supports = np.tile(POSE, (4, 2, 1)), np.zeros((4, 2, 3))
    rng = np.random.default_rng(1)
    noisy = add_process_noise(poses, STDDEV, rng, supports)
    assert noisy.shape == (4, 2, 7)
    np.testing.assert_array_equal(poses, np.tile(POSE, (4, 2, 1)))
    assert not np.any(supports)


def test_first_particles_are_spread_in_the_plane_only():
    rng = np.random.default_rng(1)
    poses = sample_around(POSE, N, STDDEV, rng)
    assert poses.shape == (N, 7)
    dp, dr = _shift_and_turn(poses)
    np.testing.assert_array_equal(dp[:, 2], 0)
    variance = STDDEV.position**2 / 2
    np.testing.assert_allclose(
        dp.T @ dp / N, np.diag([variance] * 2 + [0]), atol=0.04 * variance
    )
    assert _rms(dr) == pytest.approx(STDDEV.rotation, rel=0.02)
    np.testing.assert_allclose(
        dr.T @ dr / N,
        STDDEV.rotation**2 / 3 * np.eye(3),
        atol=0.04 * STDDEV.rotation**2 / 3,
    )


def test_first_particles_without_a_spread_are_the_detection():
    poses = sample_around(POSE, 3, PoseStddev(), np.random.default_rng(1))
    np.testing.assert_allclose(poses, np.tile(POSE, (3, 1)), atol=1e-15)


def test_a_pose_survives_the_way_through_a_rigid_transform():
    np.testing.assert_allclose(
        pose_array(rigid_transform(POSE)), POSE, atol=1e-15
    )
    twice = rigid_transform(np.concatenate([2 * POSE[:4], POSE[4:]]))
    assert twice.IsNearlyEqualTo(rigid_transform(POSE), 1e-15)
