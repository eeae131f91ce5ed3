"""What the visibility of a particle says about its weight (Section 4.3)."""

import numpy as np

from pbpf_drake.config.visibility_config import VisibilityConfig


def visibility_log_factor(
    visibility: np.ndarray, *, detected: bool, config: VisibilityConfig
) -> np.ndarray:
    """Returns by what visibility changes the particles' log weights, (M,).

    Without a detection it is log W_H where v < V_H, and log W_L elsewhere:
    the paper leaves v = V_H open, here it counts as visible. With a detection
    it is log alpha_W where v < V_L, and 0 elsewhere.

    Args:
        visibility: the scores v, (M,), in [0, 1].
        detected: whether the object was detected at this step.
        config: the object's thresholds and factors.
    """
    if detected:
        hidden = visibility < config.low_visibility
        return np.where(hidden, np.log(config.penalty), 0.0)
    hidden = visibility < config.high_visibility
    return np.log(np.where(hidden, config.high_weight, config.low_weight))
