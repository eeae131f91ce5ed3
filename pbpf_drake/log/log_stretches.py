"""Finds the part of a log in which time goes on without jumping back.

Stamps jump back where a bag is played in a loop while it is recorded, or where
a simulator is reset. Before and after are two manipulations, not one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pbpf_drake.bags.log_notes import LogNotes, TopicNotes
from pbpf_drake.log.log_samples import RawStamped, SampleT

# Smaller steps back are messages out of order (in nanoseconds).
_MIN_STEP = 10**9
# So many stamps before a jump are all later than so many after it. One stamp
# that is wrong is no jump.
_WITNESSES = 3


@dataclass(frozen=True)
class LogStretch:
    """A part of a log.

    Attributes:
        begin: log time from which on it lasts (in nanoseconds).
        end: log time before which it ends (in nanoseconds).
    """

    begin: float = -np.inf
    end: float = np.inf

    def Has(self, message: RawStamped[object]) -> bool:
        """Tells if a message is in this part."""
        return self.begin <= message.log_time < self.end

    def Of(
        self, messages: Sequence[RawStamped[SampleT]], notes: TopicNotes
    ) -> list[RawStamped[SampleT]]:
        """Returns the messages in this part.

        Args:
            messages: in any order.
            notes: counts those that aren't.
        """
        kept = []
        for message in messages:
            if self.Has(message):
                kept.append(message)
            else:
                notes.CountLeftOut(
                    "of another stretch of the log, as stamps jump back"
                )
        return kept


def find_stretch(
    messages: Sequence[RawStamped[object]], notes: LogNotes
) -> LogStretch:
    """Returns the stretch with the most messages; of equal ones the first.

    Args:
        messages: of a topic that has messages all the time.
        notes: says if there is more than one stretch.
    """
    stamped = sorted((m for m in messages if m.stamp), key=lambda m: m.log_time)
    stamps = np.array([m.stamp for m in stamped], dtype=np.float64)
    starts = [0, *_jumps_back(stamps), len(stamps)]
    if len(starts) == 2:
        return LogStretch()
    counts = np.diff(starts)
    chosen = int(np.argmax(counts))
    first, end = starts[chosen], starts[chosen + 1]
    notes.Add(
        f"stamps jump back by {_step(stamps, starts[1]):.1f} s, as where a bag "
        f"is looped or a simulator is reset: of {len(counts)} stretches only "
        f"the {'first' if chosen == 0 else f'{chosen + 1}th'} is used, with "
        f"{counts[chosen]} of {len(stamps)} joint states"
    )
    return LogStretch(
        begin=stamped[first].log_time if chosen else -np.inf,
        end=stamped[end].log_time if end < len(stamped) else np.inf,
    )


def _jumps_back(stamps: np.ndarray) -> list[int]:
    """Returns the indices of the stamps right after a jump back."""
    n = _WITNESSES
    if len(stamps) < 2 * n:
        return []
    windows = np.lib.stride_tricks.sliding_window_view(stamps, n)
    before, after = windows[:-n].min(axis=1), windows[n:].max(axis=1)
    steps = stamps[n - 1 : -n] - stamps[n : len(stamps) - n + 1]
    return (np.flatnonzero((before > after) & (steps > _MIN_STEP)) + n).tolist()


def _step(stamps: np.ndarray, index: int) -> float:
    return float(stamps[index - 1] - stamps[index]) / 1e9
