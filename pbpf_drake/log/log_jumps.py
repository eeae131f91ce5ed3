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
# A joint jumps and comes back if it goes this far (in m or rad), and this many
# times as far as it usually does from one sample to the next, ...
_MIN_SPIKE, _SPIKE_RATIO = 0.01, 20.0
# ... and the samples around are within this share of the way.
_MAX_SPREAD = 0.2


def without_jumps(
    messages: Sequence[Stamped[SampleT]],
    values: np.ndarray,
    notes: TopicNotes,
    names: Sequence[str] = (),
) -> list[Stamped[SampleT]]:
    """Returns the messages without those that can only be damaged.

    Args:
        messages: N in the order of their times, which all differ; at least
            one.
        values: (N, n) the positions that they say (in meters or radians).
        notes: counts what is left out.
        names: of the n positions, where they are those of joints.
    """
    jumps = find_jumps(seconds_since(messages[0].time, messages), values)
    for i in np.flatnonzero(jumps).tolist():
        what = f"whose joint {names[_widest(values, i)]!r}" if names else "that"
        notes.CountLeftOut(f"{what} is too far from those before and after it")
    return [m for m, jump in zip(messages, jumps, strict=True) if not jump]


def find_spikes(values: np.ndarray) -> list[tuple[int, int]]:
    """Returns which joints jump and come back within one sample.

    They may be too slow for find_jumps, but the two samples before and the two
    after are all near to each other, and the one between is far from them.

    Args:
        values: (N, n) positions (in meters or radians).

    Returns:
        Pairs of the sample's index and the joint's.
    """
    if len(values) < 5:
        return []
    steps = np.abs(np.diff(values, axis=0))
    typical = np.median(steps, axis=0)
    height = np.minimum(steps[1:-2], steps[2:-1])
    count = len(values) - 4
    around = np.stack([values[i : i + count] for i in (0, 1, 3, 4)])
    spread = np.ptp(around, axis=0)
    found = (height > np.maximum(_MIN_SPIKE, _SPIKE_RATIO * typical)) & (
        spread < _MAX_SPREAD * height
    )
    return [(int(i) + 2, int(j)) for i, j in np.argwhere(found)]


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


def _widest(values: np.ndarray, index: int) -> int:
    """Returns which of n values is furthest from those beside it."""
    beside = [i for i in (index - 1, index + 1) if 0 <= i < len(values)]
    return int(np.abs(values[beside] - values[index]).max(axis=0).argmax())
