"""Errors that know the shape, against brute force with scipy's rotations."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.distance import cdist
from scipy.spatial.transform import Rotation

from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.results.pose_errors import rotation_error
from pbpf_drake.results.pose_metrics import (
    add_error,
    add_s_error,
    area_under_curve,
    mssd_error,
)
from pbpf_drake.results.symmetric_error import symmetric_rotation_error

NONE = SymmetryConfig()
SQUARE = SymmetryConfig(axis=[0, 0, 1], order=4)
CAN = SymmetryConfig(axis=[1, 2, -2])
AXIS = np.array([1, 2, -2]) / 3
COUNT = 20


def _random_poses(rng, *, size: float = 1.0) -> np.ndarray:
    """Poses that are off by about size meters and radians."""
    q = Rotation.from_rotvec(size * rng.normal(size=(COUNT, 3))).as_quat()
    return np.hstack([np.roll(q, 1, axis=1), 0.1 * rng.normal(size=(COUNT, 3))])


def _rotation(X) -> Rotation:
    return Rotation.from_quat(np.roll(X[..., :4], -1, axis=-1))


def _points_at(X, points) -> np.ndarray:
    return _rotation(X).apply(points) + X[4:]


@pytest.fixture
def poses():
    rng = np.random.default_rng(2)
    points = rng.normal(size=(40, 3)) * [0.05, 0.08, 0.03]
    return _random_poses(rng), _random_poses(rng), points


def test_add_is_the_mean_distance_of_each_point_to_itself(poses):
    X, X_ref, points = poses
    found = add_error(X, X_ref, points)
    for i in range(COUNT):
        gaps = _points_at(X[i], points) - _points_at(X_ref[i], points)
        assert found[i] == pytest.approx(np.linalg.norm(gaps, axis=1).mean())


def test_add_s_is_the_mean_distance_of_true_points_to_the_nearest(poses):
    X, X_ref, points = poses
    found = add_s_error(X, X_ref, points)
    for i in range(COUNT):
        table = cdist(_points_at(X_ref[i], points), _points_at(X[i], points))
        assert found[i] == pytest.approx(table.min(axis=1).mean())
    assert np.all(found <= add_error(X, X_ref, points))


def _mssd(X, X_ref, points, turn: Rotation) -> float:
    moved = _points_at(X, points) - _points_at(X_ref, turn.apply(points))
    return np.linalg.norm(moved, axis=1).max()


@pytest.mark.parametrize("symmetry", [NONE, SQUARE])
def test_mssd_is_the_largest_distance_for_the_best_turn(poses, symmetry):
    X, X_ref, points = poses
    angles = [0] if symmetry is NONE else [0, 90, 180, 270]
    found = mssd_error(X, X_ref, points, symmetry)
    for i in range(COUNT):
        expected = min(
            _mssd(X[i], X_ref[i], points, Rotation.from_euler("z", a, True))
            for a in angles
        )
        assert found[i] == pytest.approx(expected)


def test_mssd_of_a_can_is_near_the_one_over_every_turn(poses):
    X, X_ref, points = poses
    found = mssd_error(X, X_ref, points, CAN)
    for i in range(5):
        every = [
            _mssd(X[i], X_ref[i], points, Rotation.from_rotvec(a * AXIS))
            for a in np.linspace(0, 2 * np.pi, 300)
        ]
        # A turn between two that are tried is at most 2.8 degrees off.
        reach = np.linalg.norm(points, axis=1).max() * np.pi / 64
        assert min(every) - 2e-3 <= found[i] <= min(every) + reach


def test_mssd_does_not_depend_on_how_a_long_log_is_cut(poses, monkeypatch):
    X, X_ref, points = poses
    whole = mssd_error(X, X_ref, points, CAN)
    monkeypatch.setattr("pbpf_drake.results.pose_metrics._CHUNK", 1)
    np.testing.assert_array_equal(mssd_error(X, X_ref, points, CAN), whole)


@pytest.mark.parametrize("sign", [1, -1])
def test_a_can_that_only_spins_has_no_error_that_respects_it(poses, sign):
    X_ref, points = poses[1], poses[2]
    turned = _rotation(X_ref) * Rotation.from_rotvec(1.234 * AXIS)
    X = X_ref.copy()
    X[:, :4] = sign * np.roll(turned.as_quat(), 1, axis=1)
    spin = symmetric_rotation_error(X[:, :4], X_ref[:, :4], CAN)
    np.testing.assert_allclose(spin, 0, atol=1e-7)
    np.testing.assert_allclose(mssd_error(X, X_ref, points, CAN), 0, atol=1e-9)
    assert np.all(rotation_error(X[:, :4], X_ref[:, :4]) > 1.2)


def test_perfect_estimates_have_no_error(poses):
    X, _, points = poses
    for error in (
        add_error(X, X, points),
        add_s_error(X, X, points),
        mssd_error(X, X, points, SQUARE),
    ):
        np.testing.assert_allclose(error, 0, atol=1e-12)


def test_there_may_be_no_poses_at_all():
    none, points = np.empty((0, 7)), np.eye(3)
    for error in (
        add_error(none, none, points),
        add_s_error(none, none, points),
        mssd_error(none, none, points, CAN),
    ):
        assert error.shape == (0,)


def test_area_under_the_curve_is_the_integral_of_the_share_below():
    errors = np.array([0.0, 0.01, 0.033, 0.0999, 0.1, 0.5, np.nan])

    def share(limit: float) -> float:
        return np.mean(np.nan_to_num(errors, nan=np.inf) < limit)

    breaks = [0.01, 0.033, 0.0999]
    integral, _ = quad(share, 0, 0.1, points=breaks)
    assert area_under_curve(errors) == pytest.approx(integral / 0.1)


def test_area_under_the_curve_is_one_for_no_error_and_zero_beyond_the_limit():
    assert area_under_curve(np.zeros(3)) == 1
    assert area_under_curve(np.full(3, 0.1)) == 0
    assert np.isnan(area_under_curve(np.empty(0)))
