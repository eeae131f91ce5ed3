"""Errors up to symmetry, against brute force with scipy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.results.pose_errors import rotation_error
from pbpf_drake.results.symmetric_error import symmetric_rotation_error

NONE = SymmetryConfig()
SQUARE = SymmetryConfig(axis=[0, 0, 1], order=4)
CAN = SymmetryConfig(axis=[1, 2, -2])
AXIS = np.array([1, 2, -2]) / 3
COUNT = 20


def _rotation(X) -> Rotation:
    return Rotation.from_quat(np.roll(X[..., :4], -1, axis=-1))


@pytest.fixture
def poses():
    """Two times some poses, of which only the rotations count."""
    q = Rotation.random(2 * COUNT, random_state=2).as_quat()
    return np.roll(q, 1, axis=1).reshape(2, COUNT, 4)


def test_symmetric_rotation_error_is_the_smallest_over_all_turns(poses):
    X, X_ref = poses
    found = symmetric_rotation_error(X[:, :4], X_ref[:, :4], CAN)
    angles = np.linspace(0, 2 * np.pi, 5000)
    turns = Rotation.from_rotvec(angles[:, None] * AXIS)
    for i in range(COUNT):
        turned = _rotation(X_ref[i]) * turns
        every = (turned.inv() * _rotation(X[i])).magnitude()
        assert found[i] <= every.min() + 1e-9
        assert found[i] == pytest.approx(every.min(), abs=1e-3)


def test_symmetric_rotation_error_counts_turns_that_can_be_counted(poses):
    X, X_ref = poses
    found = symmetric_rotation_error(X[:, :4], X_ref[:, :4], SQUARE)
    for i in range(COUNT):
        turns = Rotation.from_rotvec(
            np.outer(np.arange(4) * np.pi / 2, [0, 0, 1])
        )
        difference = (_rotation(X_ref[i]) * turns).inv() * _rotation(X[i])
        assert found[i] == pytest.approx(difference.magnitude().min())


def test_without_symmetry_it_is_the_papers_rotation_error(poses):
    q, q_ref = poses[0][:, :4], poses[1][:, :4]
    np.testing.assert_allclose(
        symmetric_rotation_error(q, q_ref, NONE), rotation_error(q, q_ref)
    )
