import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import multivariate_normal, norm

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.filtering.observation_model import (
    agrees,
    detection_log_likelihood,
)
from pbpf_drake.poses.quaternions import angle_between, from_rotation_vector

STDDEV = PoseStddev(position=0.02, rotation=0.09)
START = np.array([[1.0, 0, 0, 0, 0.1, 0.2, 0.3]])


def _pose(turn, position):
    return np.concatenate([from_rotation_vector(np.array(turn)), position])


END = _pose([0.4, -0.8, 0.2], [0.5, 0.0, 0.9])[None]


def _scipy(pose):
    return Rotation.from_quat(pose[[1, 2, 3, 0]])


def test_likelihood_is_that_of_independent_gaussians():
    rng = np.random.default_rng(3)
    turns = 0.1 * rng.standard_normal((50, 3))
    shifts = 0.02 * rng.standard_normal((50, 3))
    particles = np.array(
        [
            _pose(r, [0.3, 0.1, 0.0] + p)
            for r, p in zip(turns, shifts, strict=True)
        ]
    )
    detection = _pose([0.0, 0.0, 0.0], [0.3, 0.1, 0.0])
    log_likelihood = detection_log_likelihood(particles, detection, STDDEV)
    expected = multivariate_normal(cov=STDDEV.position**2 * np.eye(3)).logpdf(
        shifts
    ) + norm(scale=STDDEV.rotation).logpdf(np.linalg.norm(turns, axis=1))
    # Both are known up to a constant; the share of outliers is small.
    np.testing.assert_allclose(
        log_likelihood - log_likelihood[0], expected - expected[0], atol=0.02
    )


def test_likelihood_is_highest_at_the_detection():
    particles = np.concatenate([END, START])
    values = detection_log_likelihood(particles, END[0], STDDEV)
    assert values[0] == pytest.approx(0, abs=1e-4)
    assert values[1] < -20


def test_what_is_further_off_than_outliers_are_says_nothing_more():
    """The ratio of two particles' weights, near one outlier and far."""
    shifts = np.array([0.0, 0.02])
    particles = np.array([_pose([0, 0, 0], [x, 0, 0]) for x in shifts])
    ratios = []
    for x in (0.05, 0.1, 0.2, 0.5):
        values = detection_log_likelihood(
            particles, _pose([0, 0, 0], [x, 0, 0]), STDDEV
        )
        ratios.append(values[1] - values[0])
    # A Gaussian's would go on: 2, 4.5, 9.5, 24.5.
    assert ratios[0] == pytest.approx(2.0, abs=0.01)
    assert 2.0 < ratios[1] < 4.5
    np.testing.assert_allclose(ratios[2:], 0.0, atol=1e-3)


def test_an_outlier_of_the_position_keeps_its_rotation():
    particles = np.array([_pose([0, 0, yaw], [0, 0, 0]) for yaw in (0.0, 0.09)])
    values = detection_log_likelihood(
        particles, _pose([0, 0, 0], [0.4, 0, 0]), STDDEV
    )
    assert values[0] - values[1] == pytest.approx(0.5, abs=1e-3)


def test_likelihood_knows_no_sign_of_a_quaternion():
    negative = END.copy()
    negative[:, :4] *= -1
    detection = _pose([0.1, 0.0, 0.0], [0.5, 0.0, 0.9])
    np.testing.assert_allclose(
        detection_log_likelihood(negative, detection, STDDEV),
        detection_log_likelihood(END, detection, STDDEV),
        rtol=1e-12,
    )


def test_likelihood_of_the_opposite_orientation_is_that_of_half_a_turn():
    wide = PoseStddev(position=0.02, rotation=1.0)
    flipped = _pose([np.pi, 0, 0], START[0, 4:])
    assert angle_between(flipped[:4], START[0, :4]) == pytest.approx(np.pi)
    value = detection_log_likelihood(START, flipped, wide)
    assert value[0] == pytest.approx(-0.5 * np.pi**2, abs=1e-3)


@pytest.mark.parametrize(
    "distance, angle, expected",
    [(4.9, 4.9, True), (5.1, 0.0, False), (0.0, 5.1, False)],
)
def test_an_outlier_is_five_deviations_off_in_either(distance, angle, expected):
    turn = from_rotation_vector(np.array([0.0, angle * STDDEV.rotation, 0.0]))
    detection = np.array([*turn, 0.1 + distance * STDDEV.position, 0.2, 0.3])
    assert agrees(START, detection, STDDEV) == expected


def test_one_particle_is_enough_to_agree():
    far = START + [0, 0, 0, 0, 1.0, 0, 0]
    assert agrees(np.concatenate([far, START]), START[0], STDDEV)
    assert not agrees(far, START[0], STDDEV)
