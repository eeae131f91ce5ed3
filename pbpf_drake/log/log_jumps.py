"""Finds samples of a motion that are damaged: nothing can be that fast.

Not every kind of log has checksums.
"""

from collections.abc import Sequence

import numpy as np

from pbpf_drake.bags.log_notes import TopicNotes
from pbpf_drake.log.log_samples import SampleT, Stamped
from pbpf_drake.log.stamp_order import seconds_since

# Faster than anything that is pushed, and than any robot (in m/s and rad/s).
_MAX_SPEED = 50.0


def without_jumps(
    messages: Sequence[Stamped[SampleT]],
    values: np.ndarray,
    notes: TopicNotes,
) -> list[Stamped[SampleT]]:
    """Returns the messages without those that can only be damaged.

    Args:
        messages: N in the order of their times, which all differ; at least
            one.
        values: (N, n) the positions that they say (in meters or radians).
        notes: counts what is left out.
    """
    jumps = find_jumps(seconds_since(messages[0].time, messages), values)
    for _ in range(np.count_nonzero(jumps)):
        notes.CountLeftOut("that is too far from those before and after it")
    return [m for m, jump in zip(messages, jumps, strict=True) if not jump]


def find_jumps(times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Returns which samples are far from those beside them.

    A sample jumps if its two neighbours are near to each other, but it is
    near to neither. The first and the last sample have one neighbour: they
    jump if they are far from it, and the neighbour is near to its other
    neighbour. A motion that jumps and stays there is left alone.

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
    """Tells if the way from a sample to the one ``step`` later is too fast."""
    distance = np.abs(values[step:] - values[:-step]).max(axis=1)
    return distance > _MAX_SPEED * (times[step:] - times[:-step])
