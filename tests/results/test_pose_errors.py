import dataclasses

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
import pytest
from track_fixtures import make_record, make_truth

from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.poses.quaternions import (
    from_rotation_vector,
    multiply,
    normalize,
)
from pbpf_drake.results.pose_errors import (
    compute_errors,
    position_error,
    position_stddev,
    rotation_error,
    rotation_stddev,
)


def test_position_error_is_the_euclidean_distance():
    p = np.array([[[1.0, 2.0, 3.0]], [[0.0, 0.0, 0.0]]])
    p_ref = np.array([[1.0, 2.0, 3.0], [3.0, 4.0, 12.0]])
    expected = [[0.0, np.sqrt(4 + 4 + 81)], [np.sqrt(14), 13.0]]
    np.testing.assert_allclose(position_error(p, p_ref), expected)


def test_rotation_error_is_the_angle_of_drakes_relative_rotation():
    rng = np.random.default_rng(3)
    q, q_ref = normalize(rng.normal(size=(2, 200, 4)))
    found = rotation_error(q, q_ref)
    for i in range(200):
        R = RotationMatrix(Quaternion(q[i]))
        R_ref = RotationMatrix(Quaternion(q_ref[i]))
        angle = (R_ref @ R.inverse()).ToAngleAxis().angle()
        assert found[i] == pytest.approx(min(angle, 2 * np.pi - angle))


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, np.pi - 1e-6, 4.0])
def test_rotation_error_is_the_smaller_angle_whatever_the_signs(angle):
    rng = np.random.default_rng(4)
    q_ref = normalize(rng.normal(size=(50, 4)))
    axis = rng.normal(size=(50, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    q = multiply(from_rotation_vector(angle * axis), q_ref)
    expected = min(angle, 2 * np.pi - angle)
    for p, p_ref in ((q, q_ref), (-q, q_ref), (q_ref, q)):
        np.testing.assert_allclose(
            rotation_error(p, p_ref), expected, rtol=1e-9, atol=1e-12
        )


def test_errors_up_to_symmetry_leave_out_the_turn_about_the_axis():
    record = make_record()
    turn = from_rotation_vector(np.array([0.0, 1.4, 0.0]))
    # The record's own turn is 0.12 rad about y and 0.05 rad about z.
    record.poses[..., :4] = multiply(record.poses[..., :4], turn)
    can = SymmetryConfig(axis=[0.0, 1.0, 0.0])
    errors = compute_errors(record, "box", make_truth(), can)
    assert np.all(errors.rotation > 1.3)
    np.testing.assert_allclose(errors.symmetric_rotation, 0.05, atol=1e-3)
    for symmetry in None, SymmetryConfig():
        plain = compute_errors(record, "box", make_truth(), symmetry)
        np.testing.assert_array_equal(plain.symmetric_rotation, plain.rotation)


def test_errors_are_against_the_truth_at_the_time_of_the_update():
    errors = compute_errors(make_record(), "box", make_truth())
    np.testing.assert_allclose(errors.position, 0.05)
    np.testing.assert_allclose(errors.rotation, 0.13)


def test_errors_are_unknown_outside_the_span_of_the_truth():
    truth = make_truth(start=2.5, end=7.0)
    errors = compute_errors(make_record(), "box", truth)
    known = np.isfinite(errors.position)
    np.testing.assert_array_equal(np.flatnonzero(known), [2, 3, 4, 5, 6])
    np.testing.assert_array_equal(np.isfinite(errors.rotation), known)


def test_errors_are_unknown_before_the_object_is_tracked():
    record = make_record(names=("can", "box"))
    record.tracked[:4, 1] = False
    for name, first in (("can", 0), ("box", 4)):
        errors = compute_errors(record, name, make_truth())
        assert np.all(np.isnan(errors.position[:first]))
        assert np.all(np.isfinite(errors.position[first:]))


def test_errors_are_unknown_without_truth():
    errors = compute_errors(make_record(), "box", None)
    assert np.all(np.isnan(errors.position))
    assert np.all(np.isnan(errors.rotation))


def test_stddev_is_the_root_mean_square_distance_of_particles():
    rng = np.random.default_rng(5)
    deviations = rng.normal(size=(1000, 6)) * [1, 2, 3, 0.1, 0.2, 0.3]
    covariance = deviations.T @ deviations / 1000
    record = make_record()
    record.covariances[:] = covariance
    squares = np.mean(deviations**2, axis=0)
    expected = np.sqrt(squares[3:].sum())
    np.testing.assert_allclose(position_stddev(record, "box"), expected)
    expected = np.sqrt(squares[:3].sum())
    np.testing.assert_allclose(rotation_stddev(record, "box"), expected)


def test_stddev_is_unknown_without_particles_or_while_not_tracked():
    record = make_record()
    record.tracked[:3] = False
    known = np.isfinite(position_stddev(record, "box"))
    np.testing.assert_array_equal(known, record.tracked[:, 0])
    bare = dataclasses.replace(record, particles=record.particles[:, :0])
    assert np.all(np.isnan(position_stddev(bare, "box")))
