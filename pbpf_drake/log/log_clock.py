"""Places the messages of a log in time, whatever clocks they are stamped by.

A message has a stamp, written by its sender, and a log time, written by the
recorder. Usually both are of one clock, and their difference is the delay.
Where the stamps are of another clock, such as a simulated one, only they count.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pbpf_drake.bags.log_notes import LogNotes, TopicNotes
from pbpf_drake.log.log_samples import RawStamped, SampleT, Stamped

# Stamps and log times that are further apart are of different clocks (in
# nanoseconds).
_MAX_DELAY = 10**9
# A stamp that is further off is damaged (in nanoseconds).
_MAX_ERROR = 3600 * 10**9


@dataclass(frozen=True)
class LogClock:
    """How the log times of a log's messages are related to their stamps.

    Attributes:
        delay: how long after its stamp a message usually is recorded (in
            nanoseconds).
    """

    delay: int

    @property
    def is_shared(self) -> bool:
        """Whether stamps and log times are of one clock."""
        return abs(self.delay) <= _MAX_DELAY

    def Place(
        self, messages: Sequence[RawStamped[SampleT]], notes: TopicNotes
    ) -> list[Stamped[SampleT]]:
        """Returns the messages of a topic as they were received.

        A message without a stamp gets its log time. Where stamps and log
        times are of different clocks, messages are taken as received at their
        stamps. A message whose stamp is an hour off is left out.

        Args:
            messages: in any order.
            notes: counts what is left out.
        """
        stamped = []
        for m in sorted(messages, key=lambda m: m.log_time):
            time = m.stamp or m.log_time - (0 if self.is_shared else self.delay)
            if abs(m.log_time - self.delay - time) > _MAX_ERROR:
                notes.CountLeftOut(
                    "whose stamp is more than an hour off the log time"
                )
                continue
            received = max(time, m.log_time) if self.is_shared else time
            stamped.append(Stamped(time, received, m.value))
        return stamped


def find_clock(
    messages: Sequence[RawStamped[object]], notes: LogNotes
) -> LogClock:
    """Returns how log times are related to stamps.

    Args:
        messages: of a topic whose messages have little delay.
        notes: says if stamps and log times are of different clocks.
    """
    delays = [m.log_time - m.stamp for m in messages if m.stamp]
    clock = LogClock(int(np.median(delays)) if delays else 0)
    if not clock.is_shared:
        notes.Add(
            f"log times are {clock.delay / 1e9:.1f} s after stamps, so they "
            "are of another clock: detections are taken as received at their "
            "stamps"
        )
    return clock
