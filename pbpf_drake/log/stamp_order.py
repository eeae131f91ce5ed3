"""Puts the messages of a topic in the order of their stamps."""

from collections.abc import Sequence

import numpy as np

from pbpf_drake.bags.log_notes import TopicNotes
from pbpf_drake.log.log_samples import SampleT, Stamped


def in_stamp_order(
    messages: Sequence[Stamped[SampleT]], notes: TopicNotes
) -> list[Stamped[SampleT]]:
    """Returns messages sorted by time; of equal times the first received.

    Args:
        messages: at least one, as they were received.
        notes: counts what was out of order or is left out.
    """
    latest = messages[0].time
    for message in messages:
        if message.time < latest:
            notes.Count("put in order", "with an earlier stamp")
        latest = max(latest, message.time)
    kept: list[Stamped[SampleT]] = []
    for message in sorted(messages, key=lambda m: m.time):
        if kept and kept[-1].time == message.time:
            notes.CountLeftOut("with the stamp of an earlier one")
        else:
            kept.append(message)
    return kept


def seconds_since(
    start: int, messages: Sequence[Stamped[object]]
) -> np.ndarray:
    """Returns (N,) the times of messages after ``start`` (in seconds).

    Args:
        start: (in nanoseconds).
        messages: N of them.
    """
    return np.array([(m.time - start) / 1e9 for m in messages])
