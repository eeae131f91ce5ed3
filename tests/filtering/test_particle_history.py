import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from pbpf_drake.filtering.particle_history import ParticleHistory, poses_between
from pbpf_drake.poses.quaternions import from_rotation_vector

START = np.array([[1.0, 0, 0, 0, 0.1, 0.2, 0.3]])


def _pose(turn, position):
    return np.concatenate([from_rotation_vector(np.array(turn)), position])


END = _pose([0.4, -0.8, 0.2], [0.5, 0.0, 0.9])[None]


def _scipy(pose):
    return Rotation.from_quat(pose[[1, 2, 3, 0]])


@pytest.mark.parametrize("fraction", [-1.0, 0.0])
def test_pose_at_the_start_and_before_is_the_first(fraction):
    np.testing.assert_array_equal(poses_between(START, END, fraction), START)


@pytest.mark.parametrize("fraction", [1.0, 1.5])
def test_pose_at_the_end_and_after_is_the_last(fraction):
    np.testing.assert_allclose(
        poses_between(START, END, fraction), END, atol=1e-15
    )


@pytest.mark.parametrize("fraction", [0.1, 0.25, 0.5, 0.9])
def test_pose_in_between_is_a_straight_way_and_nearly_an_even_turn(fraction):
    pose = poses_between(START, END, fraction)[0]
    np.testing.assert_allclose(
        pose[4:], (1 - fraction) * START[0, 4:] + fraction * END[0, 4:]
    )
    slerp = Slerp(
        [0, 1], Rotation.concatenate([_scipy(START[0]), _scipy(END[0])])
    )
    error = (slerp(fraction).inv() * _scipy(pose)).magnitude()
    assert error < (1e-12 if fraction == 0.5 else 5e-3)
    np.testing.assert_allclose(np.linalg.norm(pose[:4]), 1, atol=1e-15)


def test_the_sign_of_a_quaternion_makes_no_difference_on_the_way():
    other = END.copy()
    other[:, :4] *= -1
    np.testing.assert_allclose(
        poses_between(START, other, 0.3),
        poses_between(START, END, 0.3),
        atol=1e-15,
    )


def _history(*times: float) -> ParticleHistory:
    """Two objects of one particle; x is the time, and its square."""
    poses = np.zeros((len(times), 1, 2, 7))
    poses[..., 0] = 1.0
    finite = np.where(np.isfinite(times), times, 99.0)
    poses[:, 0, 0, 4], poses[:, 0, 1, 4] = finite, finite**2
    return ParticleHistory(np.array(times), poses)


@pytest.mark.parametrize(
    "time, x",
    [(0.4, 0.4), (0.35, 0.35), (0.2, 0.2), (0.15, 0.15), (0.05, 0.1), (9, 0.4)],
)
def test_a_particle_is_where_it_was_at_a_time(time, x):
    history = _history(-np.inf, 0.1, 0.2, 0.4)
    assert history.at(time, 0)[0, 4] == pytest.approx(x)


def test_between_two_times_the_way_is_straight():
    assert _history(0.0, 1.0, 3.0).at(2.0, 1)[0, 4] == pytest.approx(5.0)


def test_each_object_is_where_it_was_when_it_was_last_seen():
    imaged = _history(0.0, 1.0, 3.0).at_last_images({1: 2.0})
    np.testing.assert_allclose(imaged[0, :, 4], [3.0, 5.0])


def test_a_step_without_length_gives_no_nan():
    assert np.isfinite(_history(0.2, 0.2).at(0.2, 0)).all()
