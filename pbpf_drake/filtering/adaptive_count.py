"""How many particles a belief needs (Fox, 2003).

A belief is cut into bins of poses. With

    n = (k - 1) / (2 ε) (1 - 2 / (9 (k - 1)) + sqrt(2 / (9 (k - 1))) z)³

particles in k bins, the Kullback-Leibler divergence between the particles and
the belief, as histograms over these bins, is at most ε with the probability
that the standard normal distribution has below z. The cube is Wilson and
Hilferty's form of the quantile of χ² with k - 1 degrees of freedom (D. Fox,
Adapting the Sample Size in Particle Filters Through KLD-Sampling, 2003).
"""

import math
from statistics import NormalDist

import numpy as np

from pbpf_drake.config.adaptive_count_config import AdaptiveCountConfig
from pbpf_drake.filtering.filter_state import FilterState
from pbpf_drake.filtering.resampling import (
    effective_sample_size,
    systematic_resample,
)
from pbpf_drake.filtering.update_step import UpdateStep
from pbpf_drake.poses import quaternions


def count_particles(
    state: FilterState,
    step: UpdateStep,
    u: float,
    most: int | None,
    config: AdaptiveCountConfig,
) -> int:
    """Returns n, how many particles an update has.

    Where a track begins it has as many as it may: what will be believed isn't
    in the particles yet.

    Args:
        state: the state after the last update.
        step: the update.
        u: in [0, 1), of the resampling.
        most: n is at most this, unless the configured minimum is more; None
            means M.
        config: says whether, and how, n depends on the belief.
    """
    count = len(state.weights)
    if most is not None:
        count = min(count, max(most, config.min_particles))
    if not config.to_belief or not step.active[list(step.detections)].all():
        return count
    labels = bin_labels(
        state.poses[:, step.active],
        state.estimates[0, step.active],
        (config.bin_position, config.bin_rotation),
    )
    size = effective_sample_size(state.weights)
    return needed_particles(
        labels,
        state.weights,
        u,
        efficiency=min(size / state.num_used[0], 1.0),
        most=count,
        config=config,
    )


def kld_sample_size(
    num_bins: int, max_divergence: float, confidence: float
) -> int:
    """Returns n of the bound, rounded up; 1 where there is but one bin.

    Args:
        num_bins: k, at least 1.
        max_divergence: ε (in nats).
        confidence: in (0, 1).
    """
    if num_bins <= 1:
        return 1
    freedom = num_bins - 1
    share = 2 / (9 * freedom)
    root = 1 - share + math.sqrt(share) * NormalDist().inv_cdf(confidence)
    # Below 0, where little confidence is asked for, it is no quantile.
    return max(1, math.ceil(freedom / (2 * max_divergence) * root**3))


def bin_labels(
    poses: np.ndarray, centers: np.ndarray, size: tuple[float, float]
) -> np.ndarray:
    """Returns the numbers of the bins that poses are in, (M, K).

    The bins are cubes of positions and of rotation vectors. One of them has
    its middle at the center, so that a narrow belief has one bin.

    Args:
        poses: (M, K, 7): qw qx qy qz, x y z (in meters).
        centers: (K, 7), such as the mean.
        size: edges of a bin, of position and rotation (in meters and radians).
    """
    turns = quaternions.multiply(
        poses[..., :4], quaternions.conjugate(centers[:, :4])
    )
    offsets = np.concatenate(
        [
            (poses[..., 4:] - centers[:, 4:]) / size[0],
            quaternions.to_rotation_vector(turns) / size[1],
        ],
        axis=-1,
    )
    labels = np.empty(poses.shape[:2], dtype=int)
    for k in range(poses.shape[1]):
        _, found = np.unique(
            np.round(offsets[:, k]), axis=0, return_inverse=True
        )
        labels[:, k] = found.ravel()
    return labels


def needed_particles(
    labels: np.ndarray,
    weights: np.ndarray,
    u: float,
    *,
    efficiency: float,
    most: int,
    config: AdaptiveCountConfig,
) -> int:
    """Returns the least n that is enough for the bins that n survivors are in.

    It is what Fox's sampling ends with, if particles are drawn by systematic
    resampling. His bound is for particles that all count the same. After they
    are weighed, n of them are worth fewer, by about the same factor as at the
    last update. So a filter whose weights collapse gets more particles, though
    its few survivors are in few bins.

    Of several objects the one with most bins counts: of each, the particles
    show what is believed of that object.

    Args:
        labels: (M, K) bins of the particles.
        weights: (M,) that sum to 1.
        u: in [0, 1), of the resampling.
        efficiency: effective sample size of the last update, as a share of its
            particles.
        most: n is at most this.
        config: the bound's.
    """
    needed = config.min_particles
    while True:
        # Sums of equal weights miss theirs by rounding.
        count = min(math.ceil(needed / efficiency - 1e-6), most)
        survivors = systematic_resample(weights, u, count)
        num_bins = max(
            (len(np.unique(of_object)) for of_object in labels[survivors].T),
            default=1,
        )
        bound = kld_sample_size(
            num_bins, config.max_divergence, config.confidence
        )
        if bound <= needed or count == most:
            return count
        needed = bound
