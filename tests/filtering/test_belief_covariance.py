import numpy as np
from update_fixtures import NOMINAL, make_cloud

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.filtering.belief_covariance import belief_covariances
from pbpf_drake.filtering.filter_state import MakeInitialState

NOISE = PoseStddev(position=0.16, rotation=0.43)


def test_what_is_not_tracked_yet_is_as_uncertain_as_first_particles_are():
    (covariance,) = belief_covariances(MakeInitialState(5, NOMINAL), NOISE)
    rotation, position = 0.43**2 / 3, 0.16**2 / 2
    np.testing.assert_allclose(
        covariance, np.diag([rotation] * 3 + [position] * 2 + [0.0])
    )


def test_what_is_tracked_is_as_uncertain_as_its_particles_are_spread():
    expected = np.diag([4e-4, 1e-4, 9e-4])
    state = make_cloud(np.array([0.3, 0.2, 0.1]), expected, 100_000)
    (covariance,) = belief_covariances(state, NOISE)
    np.testing.assert_allclose(covariance[:3], 0.0, atol=1e-15)
    np.testing.assert_allclose(covariance[3:, 3:], expected, atol=1e-5)
