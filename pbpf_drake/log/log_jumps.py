"""Finds samples of a motion that are damaged: nothing can be that fast.

Not every kind of log has checksums.
"""

import numpy as np

# Faster than anything that is pushed, and than any robot (in m/s and rad/s).
_MAX_SPEED = 50.0


def find_jumps(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Returns which samples are far from those beside them.

    A sample is, if its neighbours are near to each other and it is near to
    neither; the first and the last one, if their neighbour is near to its
    other neighbour. A motion that jumps and stays there is left alone.

    Args:
        times: (N,) strictly increasing (in seconds).
        values: (N, n) positions (in meters or radians).

    Returns:
        (N,) true for those that jump.
    """
    if len(times) < 3:
        return np.zeros(len(times), dtype=bool)
    fast = _is_fast(times, values, 1)
    over = _is_fast(times, values, 2)
    inner = fast[:-1] & fast[1:] & ~over
    first, last = fast[0] & ~fast[1], fast[-1] & ~fast[-2]
    return np.concatenate([[first], inner, [last]])


def _is_fast(times: np.ndarray, values: np.ndarray, step: int) -> np.ndarray:
    """Tells of every sample if the way to a later one is too fast."""
    distance = np.abs(values[step:] - values[:-step]).max(axis=1)
    return distance > _MAX_SPEED * (times[step:] - times[:-step])
