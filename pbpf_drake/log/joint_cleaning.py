"""Makes the record of the robot's motion, without what can't be used."""

from collections.abc import Mapping, Sequence

import numpy as np

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import TopicNotes
from pbpf_drake.log.log_jumps import without_jumps
from pbpf_drake.log.log_records import JointRecord
from pbpf_drake.log.log_samples import JointSample, Stamped
from pbpf_drake.log.stamp_order import in_stamp_order, seconds_since


def make_joint_record(
    messages: Sequence[Stamped[JointSample]],
    *,
    names: Mapping[str, str],
    notes: TopicNotes,
) -> tuple[JointRecord, int]:
    """Returns the robot's motion, and when it starts.

    Args:
        messages: as they were received.
        names: the joints' names in the log by their names in the model, in
            the order of the record's columns.
        notes: counts what is left out.

    Returns:
        The record, and the time of its first sample (in nanoseconds).

    Raises:
        LogError: no message can be used.
    """
    wanted = list(names.values())
    kept = _whole(messages, wanted, notes)
    kept = in_stamp_order(kept, notes)
    kept = without_jumps(kept, _positions(kept, wanted), notes)
    start = kept[0].time
    record = JointRecord(
        names=tuple(names),
        times=seconds_since(start, kept),
        positions=_positions(kept, wanted),
        velocities=_velocities(kept, wanted),
    )
    return record, start


def _whole(
    messages: Sequence[Stamped[JointSample]],
    wanted: Sequence[str],
    notes: TopicNotes,
) -> list[Stamped[JointSample]]:
    """Returns the messages that have a finite position for every joint."""
    kept = []
    for message in messages:
        reason = _problem(message.value, wanted)
        if reason:
            notes.CountLeftOut(reason)
        else:
            kept.append(message)
    if not kept:
        raise LogError(
            "there is no joint state that can be used; "
            + "; ".join(notes.Sentences())
        )
    others = {name for m in kept for name in m.value.names} - set(wanted)
    if others:
        notes.Add(
            f"ignored the joints {sorted(others)}, which are not the robot's"
        )
    return kept


def _problem(sample: JointSample, wanted: Sequence[str]) -> str:
    """Returns why a sample can't be used, as a clause; empty if it can."""
    if len(sample.positions) != len(sample.names):
        return (
            f"whose field position has {len(sample.positions)} values for "
            f"{len(sample.names)} names"
        )
    missing = [name for name in wanted if name not in sample.names]
    if missing:
        return f"without the joints {missing}; joints are {sample.names}"
    if not np.all(np.isfinite(_pick(sample, sample.positions, wanted))):
        return "whose field position is not finite"
    return ""


def _pick(
    sample: JointSample, values: Sequence[float], wanted: Sequence[str]
) -> list[float]:
    """Returns the values of the wanted joints, in their order."""
    return [values[sample.names.index(name)] for name in wanted]


def _positions(
    messages: Sequence[Stamped[JointSample]], wanted: Sequence[str]
) -> np.ndarray:
    samples = [m.value for m in messages]
    return np.array([_pick(s, s.positions, wanted) for s in samples])


def _velocities(
    messages: Sequence[Stamped[JointSample]], wanted: Sequence[str]
) -> np.ndarray | None:
    """Returns the velocities, or None unless every message has them all."""
    samples = [m.value for m in messages]
    if any(len(s.velocities) != len(s.names) for s in samples):
        return None
    rows = np.array([_pick(s, s.velocities, wanted) for s in samples])
    return rows if np.all(np.isfinite(rows)) else None
