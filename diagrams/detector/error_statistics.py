"""Statistics of what a detector does in one run.

Errors are those of the last detection, which is held until the next one. Early
in a run the view is clear, and each update has a new detection. Once the object
is hidden, a pose may be held for long while the object moves on: it is stale.
"""

from collections.abc import Callable
import itertools

import numpy as np

from pbpf_drake.config.detector_config import DetectorConfig

# A change of the error (in meters) that no clear view has.
_JUMP = 0.03
# By how much the error of a held pose changes at most from one update to the
# next, while the object moves on at 23 mm/s (in meters, and in radians).
_DRIFT = (0.004, 0.025)
# A new detection that is further off is an outlier (in meters, and in radians).
_OUTLIER = (0.1, 0.5)
# For so many updates before the first jump the view no longer counts as clear,
# nor for so many at the start.
_MARGIN = 6


def is_stale(errors: np.ndarray) -> np.ndarray:
    """Returns at which updates the pose is a held one, as errors tell, (N,).

    Two or more changes in a row that the object's own motion explains are
    taken for a held pose. Before the first jump the view is clear, and no pose
    counts as held.

    Args:
        errors: (N, 2) [m, rad].
    """
    changes = np.abs(np.diff(errors, axis=0))
    jumps = np.flatnonzero(changes[:, 0] > _JUMP)
    small = np.all(changes < _DRIFT, axis=1)
    small[: jumps[0] if len(jumps) else len(small)] = False
    result, start = np.zeros(len(errors), dtype=bool), 1
    for value, group in itertools.groupby(small):
        length = len(list(group))
        result[start : start + length] = value and length >= 2
        start += length
    return result


def describe_errors(errors: np.ndarray) -> dict[str, float]:
    """Returns the statistics of one run, NaN where there is nothing to count.

    Args:
        errors: (N, 2) [m, rad].
    """
    changes = np.diff(errors, axis=0)
    jumps = np.flatnonzero(np.abs(changes[:, 0]) > _JUMP)
    end = max(jumps[0] - _MARGIN, 0) if len(jumps) else len(changes)
    clear = changes[_MARGIN:end] if end > 2 * _MARGIN else changes[:0]
    stale = is_stale(errors)
    is_off = (errors > _OUTLIER) & ~stale[:, np.newaxis]
    result = {"stale share": float(stale.mean())}
    for k, name in enumerate(("position", "rotation")):
        off = errors[is_off[:, k], k]
        result |= {
            f"{name}: mean": float(errors[:, k].mean()),
            f"{name}: standard deviation": float(errors[:, k].std()),
            f"{name}: share of outliers": float(is_off[:, k].mean()),
            f"{name}: outliers' median": _or_nan(np.median, off),
            f"{name}: outliers' maximum": _or_nan(np.max, off),
            f"{name}: last": float(errors[-1, k]),
            f"{name}: step noise": _or_nan(np.std, clear[:, k]),
        }
    return result


def describe_images(
    visibility: np.ndarray, config: DetectorConfig
) -> dict[str, float]:
    """Returns in which shares of a run's images an object is clear or hidden.

    Args:
        visibility: (N,) visible shares of the object.
        config: says what is clear, and what is hidden.
    """
    clear = visibility >= config.clear_visibility
    hidden = visibility < config.hidden_visibility
    return {
        "images: clear": float(clear.mean()),
        "images: partly hidden": float((~clear & ~hidden).mean()),
        "images: hidden": float(hidden.mean()),
    }


def _or_nan(
    function: Callable[[np.ndarray], float], values: np.ndarray
) -> float:
    return float(function(values)) if len(values) else np.nan
