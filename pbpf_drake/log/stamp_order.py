"""Puts the messages of a topic in the order of their stamps."""

from collections.abc import Sequence

import numpy as np

from pbpf_drake.bags.log_notes import TopicNotes
from pbpf_drake.log.log_samples import SampleT, Stamped

# Shorter distances between samples are no gaps (in seconds).
_MIN_GAP = 0.25


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


def gap_clause(times: np.ndarray) -> str:
    """Returns a clause on the gaps between samples; empty if there is none.

    A gap is longer than a quarter of a second, and than ten times the usual
    distance.

    Args:
        times: (N,) strictly increasing (in seconds).
    """
    steps = np.diff(times)
    if not len(steps):
        return ""
    gaps = np.flatnonzero(steps > max(_MIN_GAP, 10 * float(np.median(steps))))
    if not len(gaps):
        return ""
    longest = gaps[np.argmax(steps[gaps])]
    return (
        f"there {'is 1 gap' if len(gaps) == 1 else f'are {len(gaps)} gaps'} "
        f"without messages, the longest of {steps[longest]:.2f} s from "
        f"{times[longest]:.2f} s on"
    )


def seconds_since(
    start: int, messages: Sequence[Stamped[object]]
) -> np.ndarray:
    """Returns (N,) the times of messages after ``start`` (in seconds).

    Args:
        start: (in nanoseconds).
        messages: N of them.
    """
    return np.array([(m.time - start) / 1e9 for m in messages])
