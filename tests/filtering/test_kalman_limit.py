"""Where everything is Gaussian, the filter is the exact one, but for chance."""

import numpy as np
import pytest
from update_fixtures import (
    NOMINAL,
    PERIOD,
    VELOCITY,
    FreeMotion,
    make_cloud,
    make_config,
    make_update,
    moments,
    see,
    step,
)

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.filtering.filter_state import MakeInitialState
from pbpf_drake.filtering.particle_filter_update import ParticleFilterUpdate
from pbpf_drake.poses import quaternions


class ExactFilter:
    """The Gaussian posterior of the position at the end of each period.

    A detection within a period is of a point on the straight way between the
    positions at its ends, so both are estimated together.
    """

    def __init__(self, mean, covariance, config: ParticleFilterConfig):
        self.mean, self.covariance = mean, covariance
        self.noise = config.process_noise.position**2 / 3 * np.eye(3)
        self.error = config.detection_noise.position**2 * np.eye(3)

    def step(self, seen) -> None:
        P = self.covariance
        mean = np.concatenate([self.mean, self.mean + VELOCITY * PERIOD])
        covariance = np.block([[P, P], [P, P + self.noise]])
        for fraction, z in seen:
            H = np.hstack([(1 - fraction) * np.eye(3), fraction * np.eye(3)])
            S = H @ covariance @ H.T + self.error
            gain = covariance @ H.T @ np.linalg.inv(S)
            mean = mean + gain @ (z - H @ mean)
            covariance = covariance - gain @ H @ covariance
        self.mean, self.covariance = mean[3:], covariance[3:, 3:]


@pytest.mark.parametrize(
    "fractions",
    [
        pytest.param([(1.0,)] * 12, id="one at the end of each period"),
        pytest.param([(1.0, 1.0, 1.0)] * 12, id="three at the end"),
        pytest.param([(1.0,), (), ()] * 4, id="missing ones"),
        pytest.param([(0.2, 0.7), (0.4,), ()] * 4, id="within the period"),
    ],
)
def test_many_particles_agree_with_the_exact_filter(fractions):
    config = make_config(num_particles=40_000)
    update = ParticleFilterUpdate(config=config, motion_model=FreeMotion())
    spread = np.array([[4.0, 1, 0], [1, 2, -1], [0, -1, 3]]) * 1e-4
    truth = np.array([0.3, 0.2, 0.1])
    state = make_cloud(truth, spread, config.num_particles)
    exact = ExactFilter(*moments(state), config)
    rng = np.random.default_rng(9)
    for stamps in fractions:
        seen = []
        for u in stamps:
            error = config.detection_noise.position * rng.standard_normal(3)
            seen.append((u, truth + u * VELOCITY * PERIOD + error))
        truth = truth + VELOCITY * PERIOD
        exact.step(seen)
        poses = [see(state, z, u) for u, z in seen]
        state = step(update, state, {0: poses} if poses else {})
        mean, covariance = moments(state)
        # Both in standard deviations of the exact posterior.
        whiten = np.linalg.inv(np.linalg.cholesky(exact.covariance))
        np.testing.assert_allclose(whiten @ (mean - exact.mean), 0, atol=0.07)
        np.testing.assert_allclose(
            whiten @ covariance @ whiten.T, np.eye(3), atol=0.08
        )
        np.testing.assert_allclose(state.estimates[0, 0, 4:], mean)


def test_first_particles_are_the_posterior_of_initial_spread_and_detections():
    config = make_config(
        num_particles=3000, initial_noise=PoseStddev(position=0.03)
    )
    update = ParticleFilterUpdate(config=config, motion_model=FreeMotion())
    state = MakeInitialState(3000, NOMINAL)
    p = np.array([[0.51, 0.41, 0.12], [0.5, 0.4, 0.1]])
    state = step(update, state, {0: [see(state, x) for x in p]})
    mean, covariance = moments(state)
    # Around the last, in the plane; each detection counts.
    spread, error = 0.03**2 / 2, 0.02**2
    variance = 1 / (1 / spread + 2 / error)
    expected = variance * (p[1] / spread + (p[0] + p[1]) / error)
    np.testing.assert_allclose(
        mean[:2], expected[:2], atol=4 * np.sqrt(variance / 3000)
    )
    np.testing.assert_allclose(
        covariance[:2, :2], variance * np.eye(2), atol=0.1 * variance
    )
    np.testing.assert_array_equal(state.poses[:, 0, 6], p[1, 2])
    # They were chosen by the detections; these must not count twice.
    np.testing.assert_allclose(state.weights, 1 / 3000)


def test_first_orientations_are_the_posterior_of_spread_and_detection():
    initial = PoseStddev(position=0.0, rotation=0.43)
    update = make_update(num_particles=3000, initial_noise=initial)
    state = MakeInitialState(3000, NOMINAL)
    q = quaternions.from_rotation_vector(np.array([0.3, 1.2, -0.5]))
    state = step(update, state, {0: [see(state, np.zeros(3), q=q)]})
    angles = quaternions.angle_between(state.poses[:, 0, :4], q)
    stddev = 1 / np.hypot(1 / 0.43, 1 / 0.09)
    assert np.sqrt(np.mean(angles**2)) == pytest.approx(stddev, rel=0.05)
    assert quaternions.angle_between(state.estimates[0, 0, :4], q) < 0.01
