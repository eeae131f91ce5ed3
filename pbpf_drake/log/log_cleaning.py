"""Turns the messages of a log into records, leaving out what can't be used.

Pure functions from lists of messages to the records of log_records.py.
Whatever is left out is counted in LogNotes; where nothing is left that the
filter could run on, ``LogError`` says what was expected.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
import math

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.log_clock import Stamped
from pbpf_drake.log.log_jumps import find_jumps
from pbpf_drake.log.log_records import DetectionRecord, JointRecord, PoseRecord

_DUPLICATE = "with the stamp of an earlier one"


@dataclass(frozen=True)
class JointSample:
    """A JointState: (m,) ``names`` and as many positions, if it is whole."""

    names: tuple[str, ...]
    positions: Sequence[float]
    velocities: Sequence[float]


@dataclass(frozen=True)
class PoseSample:
    """A pose: q (4,) as w, x, y, z, of any length, and p (3,) in meters."""

    q: np.ndarray
    p: np.ndarray


def make_joint_record(
    messages: Sequence[Stamped],
    *,
    names: Mapping[str, str],
    topic: str,
    notes: LogNotes,
) -> tuple[JointRecord, int]:
    """Returns the robot's motion, and when it starts.

    Args:
        messages: joint samples as they were received.
        names: the joints' names in the log by their names in the model, in
            the order of the record's columns.
        topic: their topic, for messages.
        notes: counts what is left out.

    Returns:
        The record, and the time of its first sample (in nanoseconds).

    Raises:
        LogError: no message can be used.
    """
    wanted = list(names.values())
    kept = _whole_joint_states(messages, wanted, topic, notes)
    kept = _in_order(kept, topic=topic, noun="message", notes=notes)
    rows = np.array([_row(m.value, wanted) for m in kept])
    kept = _without_jumps(kept, rows, topic, notes)
    start = kept[0].time
    record = JointRecord(
        names=tuple(names),
        times=_seconds(kept, start),
        positions=np.array([_row(m.value, wanted) for m in kept]),
        velocities=_velocities(kept, wanted),
    )
    return record, start


def _whole_joint_states(
    messages: Sequence[Stamped],
    wanted: Sequence[str],
    topic: str,
    notes: LogNotes,
) -> list[Stamped]:
    """Returns the messages that have a finite position for every joint."""
    kept = []
    for message in messages:
        reason = _joint_problem(message.value, wanted)
        if reason:
            notes.Count(topic, "left out", "message", reason)
        else:
            kept.append(message)
    if not kept:
        raise LogError(
            "there is no joint state that can be used; "
            + "; ".join(notes.Sentences(topic))
        )
    others = {name for m in kept for name in m.value.names} - set(wanted)
    if others:
        notes.Add(
            f"{topic}: ignored the joints {sorted(others)}, which are not the "
            "robot's"
        )
    return kept


def _joint_problem(sample: JointSample, wanted: Sequence[str]) -> str:
    if len(sample.positions) != len(sample.names):
        return (
            f"whose field position has {len(sample.positions)} values for "
            f"{len(sample.names)} names"
        )
    missing = [name for name in wanted if name not in sample.names]
    if missing:
        return f"without the joints {missing}; joints are {sample.names}"
    if not np.all(np.isfinite(_row(sample, wanted))):
        return "whose field position is not finite"
    return ""


def _row(sample: JointSample, wanted: Sequence[str]) -> list[float]:
    return [sample.positions[sample.names.index(name)] for name in wanted]


def _velocities(
    messages: Sequence[Stamped], wanted: Sequence[str]
) -> np.ndarray | None:
    samples = [m.value for m in messages]
    if any(len(s.velocities) != len(s.names) for s in samples):
        return None
    rows = np.array(
        [_row(replace(s, positions=s.velocities), wanted) for s in samples]
    )
    return rows if np.all(np.isfinite(rows)) else None


def make_detections(
    messages: Sequence[Stamped],
    *,
    names_by_class: Mapping[str, str],
    start: int,
    topic: str,
    notes: LogNotes,
) -> tuple[DetectionRecord, ...]:
    """Returns the detections that can be used, sorted by ``received``.

    Args:
        messages: class names with poses X_CO, as they were received.
        names_by_class: names of tracked models by the detector's class names.
        start: what the record's times are relative to (in nanoseconds).
        topic: their topic, for messages.
        notes: counts what is left out.
    """
    by_name: dict[str, list[Stamped]] = {}
    for message in messages:
        class_id, pose = message.value
        if class_id not in names_by_class:
            reason = f"of the unknown class {class_id!r}"
            notes.Count(topic, "left out", "detection", reason)
        elif is_usable(pose, topic, "detection", notes):
            name = names_by_class[class_id]
            by_name.setdefault(name, []).append(replace(message, value=pose))
    records = []
    for name, poses in by_name.items():
        for m in _in_order(poses, topic=topic, noun="detection", notes=notes):
            X_CO = _transform(m.value)
            time, received = (m.time - start) / 1e9, (m.received - start) / 1e9
            records.append(DetectionRecord(name, time, received, X_CO))
    return tuple(sorted(records, key=lambda r: (r.received, r.time, r.name)))


def make_pose_record(
    messages: Sequence[Stamped],
    *,
    start: int,
    topic: str,
    notes: LogNotes,
) -> PoseRecord | None:
    """Returns the ground truth of one object, or None if there is none.

    Args:
        messages: poses X_WO as they were received.
        start: what the record's times are relative to (in nanoseconds).
        topic: their topic, for messages.
        notes: counts what is left out.
    """
    kept = [m for m in messages if is_usable(m.value, topic, "message", notes)]
    if not kept:
        return None
    kept = _in_order(kept, topic=topic, noun="message", notes=notes)
    positions = np.array([m.value.p for m in kept])
    kept = _without_jumps(kept, positions, topic, notes)
    return PoseRecord(
        times=_seconds(kept, start),
        q_WO=np.array([unit(m.value.q) for m in kept]),
        p_WO=np.array([m.value.p for m in kept]),
    )


def is_usable(pose: PoseSample, topic: str, noun: str, notes: LogNotes) -> bool:
    """Tells if a pose can be used; counts what is wrong with it."""
    norm = math.hypot(*pose.q)  # Unlike numpy's, without overflow.
    if not np.all(np.isfinite(pose.p)):
        notes.Count(topic, "left out", noun, "whose position is not finite")
    elif not math.isfinite(norm):
        notes.Count(topic, "left out", noun, "whose quaternion is not finite")
    elif norm < 1e-6:
        notes.Count(topic, "left out", noun, "whose quaternion is zero")
    else:
        if abs(norm - 1) > 0.1:
            reason = "whose quaternion's length is off by more than 10 %"
            notes.Count(topic, "normalized", noun, reason)
        return True
    return False


def _transform(pose: PoseSample) -> RigidTransform:
    return RigidTransform(
        quaternion=Quaternion(*unit(pose.q).tolist()), p=pose.p
    )


def unit(q: np.ndarray) -> np.ndarray:
    """Returns a quaternion (4,) scaled to unit length."""
    norm = math.hypot(*q)
    # A unit quaternion is kept to the bit.
    return q if abs(norm - 1) < 1e-14 else q / norm


def _in_order(
    messages: Sequence[Stamped], *, topic: str, noun: str, notes: LogNotes
) -> list[Stamped]:
    """Returns messages sorted by time; of equal times the first received."""
    latest = messages[0].time
    for message in messages:
        if message.time < latest:
            notes.Count(topic, "put in order", noun, "with an earlier stamp")
        latest = max(latest, message.time)
    kept: list[Stamped] = []
    for message in sorted(messages, key=lambda m: m.time):
        if kept and kept[-1].time == message.time:
            notes.Count(topic, "left out", noun, _DUPLICATE)
        else:
            kept.append(message)
    return kept


def _without_jumps(
    messages: Sequence[Stamped],
    values: np.ndarray,
    topic: str,
    notes: LogNotes,
) -> list[Stamped]:
    """Returns the messages without those that can only be damaged.

    Args:
        messages: in order.
        values: (N, n) what they say, in meters or radians.
        topic: their topic, for messages.
        notes: counts what is left out.
    """
    jumps = find_jumps(_seconds(messages, messages[0].time), values)
    for _ in range(np.count_nonzero(jumps)):
        reason = "that is too far from those before and after it"
        notes.Count(topic, "left out", "message", reason)
    return [m for m, jump in zip(messages, jumps, strict=True) if not jump]


def _seconds(messages: Sequence[Stamped], start: int) -> np.ndarray:
    return np.array([(m.time - start) / 1e9 for m in messages])
