"""How uncertain the filter is of each object."""

import numpy as np

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.filtering.filter_state import FilterState
from pbpf_drake.poses.pose_statistics import pose_covariance


def belief_covariances(
    state: FilterState, initial_noise: PoseStddev
) -> np.ndarray:
    """Returns the covariances of the objects' poses, (K, 6, 6).

    The rows are the rotation vector (in radians), then the position (in
    meters), in the world; see pose_covariance. An object that isn't tracked
    yet has that of the initial noise: equal about all axes, and horizontal.

    Args:
        state: the particles, their weights and their mean.
        initial_noise: of the first particles.
    """
    covariances = pose_covariance(
        state.poses, state.weights, state.estimates[0]
    )
    rotation = initial_noise.rotation**2 / 3
    horizontal = initial_noise.position**2 / 2
    covariances[state.num_estimates == 0] = np.diag(
        [rotation] * 3 + [horizontal] * 2 + [0.0]
    )
    return covariances
