"""Places the messages of a log in time, whatever clocks they are stamped by.

A message has a stamp, written by its sender, and a log time, written by the
recorder. Usually both are of one clock, and their difference is the delay. A
simulated clock in stamps is another one: then only stamps count.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pbpf_drake.bags.log_notes import LogNotes

# Stamps and log times that are further apart are of different clocks (in
# nanoseconds).
_MAX_DELAY = 10**9
# A stamp that is further off is damaged (in nanoseconds).
_MAX_ERROR = 3600 * 10**9


@dataclass(frozen=True)
class RawStamped:
    """One decoded message.

    Attributes:
        log_time: when it was recorded (in nanoseconds).
        stamp: the stamp in its header (in nanoseconds); 0 means none.
        value: what it says.
    """

    log_time: int
    stamp: int
    value: Any


@dataclass(frozen=True)
class Stamped:
    """One decoded message, or one part of it, placed in time.

    Attributes:
        time: when it was so (in nanoseconds since the epoch).
        received: when it became known, not before (in nanoseconds).
        value: what it says.
    """

    time: int
    received: int
    value: Any


def stamp_messages(
    raw: Mapping[str, Sequence[RawStamped]],
    *,
    reference: str,
    notes: LogNotes,
) -> dict[str, list[Stamped]]:
    """Returns the messages of every topic as they were received.

    A message without a stamp gets its log time. Where stamps and log times
    are of different clocks, messages are taken as received at their stamps. A
    message whose stamp is an hour off is left out.

    Args:
        raw: messages by topic.
        reference: the topic whose messages have little delay.
        notes: counts what is left out.
    """
    delays = [m.log_time - m.stamp for m in raw[reference] if m.stamp]
    delay = int(np.median(delays)) if delays else 0
    same_clock = abs(delay) <= _MAX_DELAY
    if not same_clock:
        notes.Add(
            f"log times are {delay / 1e9:.1f} s after stamps, so they are of "
            "another clock: detections are taken as received at their stamps"
        )
    stamped: dict[str, list[Stamped]] = {topic: [] for topic in raw}
    for topic, messages in raw.items():
        for m in sorted(messages, key=lambda m: m.log_time):
            time = m.stamp or m.log_time - (0 if same_clock else delay)
            if abs(m.log_time - delay - time) > _MAX_ERROR:
                reason = "whose stamp is more than an hour off the log time"
                notes.Count(topic, "left out", "message", reason)
                continue
            received = max(time, m.log_time) if same_clock else time
            stamped[topic].append(Stamped(time, received, m.value))
    return stamped
