"""Weights in the log domain, effective sample size, systematic resampling."""

import numpy as np


def normalize_log_weights(log_weights: np.ndarray) -> np.ndarray:
    """Returns weights (M,) that sum to 1.

    Args:
        log_weights: (M,) up to a common constant. -inf and NaN are weights of
            zero. Where all are, the weights are uniform: nothing is known.
    """
    log_weights = np.where(np.isnan(log_weights), -np.inf, log_weights)
    highest = np.max(log_weights)
    if not np.isfinite(highest):
        return np.full(len(log_weights), 1.0 / len(log_weights))
    weights = np.exp(log_weights - highest)
    return weights / np.sum(weights)


def effective_sample_size(weights: np.ndarray) -> float:
    """Returns 1 / Σ w², from 1 (one particle counts) to M (all count)."""
    return float(1.0 / np.sum(np.square(weights)))


def systematic_resample(
    weights: np.ndarray, u: float, count: int | None = None
) -> np.ndarray:
    """Returns the n indices of the particles that survive, ascending.

    A comb of n teeth, 1/n apart, is laid over the cumulated weights; ``u``
    says where in the first gap it starts. A particle of weight w is taken
    ⌊nw⌋ or ⌈nw⌉ times, n w times on average.

    Args:
        weights: (M,) that sum to 1.
        u: in [0, 1).
        count: n; by default M.
    """
    if count is None:
        count = len(weights)
    teeth = (u + np.arange(count)) / count
    # The last sum is 1 but for rounding, which must not lose a tooth.
    indices = np.searchsorted(np.cumsum(weights), teeth, side="right")
    return np.minimum(indices, np.flatnonzero(weights)[-1])
