"""Puts the robot's motion together from what messages say of its joints.

Every joint has a motion of its own, from messages on any topic and at any rate.
There is a sample of all joints whenever one of them was measured: the others
are interpolated, and held before their first message and after their last.
"""

from collections.abc import Sequence

import numpy as np

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import LogNotes, TopicNotes
from pbpf_drake.log.joint_cleaning import JointMotion, joint_motions
from pbpf_drake.log.joint_plan import JointPlan, missing_joints
from pbpf_drake.log.log_records import JointRecord
from pbpf_drake.log.log_samples import JointSample, Stamped

# A joint that is held longer than this is told (in seconds).
_MAX_HOLD = 0.2


# What one joint does at N times: positions and, if all are known, velocities.
_Column = tuple[np.ndarray, np.ndarray | None]


def make_joint_record(
    messages: Sequence[tuple[TopicNotes, Sequence[Stamped[JointSample]]]],
    *,
    plan: JointPlan,
    joint_names: Sequence[str],
    notes: LogNotes,
) -> tuple[JointRecord, int]:
    """Returns the robot's motion, and when it starts.

    Args:
        messages: of each topic, as they were received, with what counts
            those that are left out.
        plan: where each joint's motion comes from.
        joint_names: the robot's joints, in the order of the record's columns.
        notes: says which joints are held, fixed or worked out.

    Returns:
        The record, and the time of its first sample (in nanoseconds).

    Raises:
        LogError: no message can be used, or a joint's motion isn't known.
    """
    motions = [
        motion
        for topic_notes, on_topic in messages
        for motion in joint_motions(
            on_topic, wanted=list(plan.logged.values()), notes=topic_notes
        )
    ]
    found = {n for _, ms in messages for m in ms for n in m.value.names}
    if not motions:
        raise LogError(
            "; ".join(
                ["there is no joint state that can be used", *notes.Sentences()]
            )
        )
    return merge_joints(
        motions,
        plan=plan,
        joint_names=joint_names,
        found=sorted(found),
        notes=notes,
    )


def merge_joints(
    motions: Sequence[JointMotion],
    *,
    plan: JointPlan,
    joint_names: Sequence[str],
    found: Sequence[str],
    notes: LogNotes,
) -> tuple[JointRecord, int]:
    """Returns the robot's motion, and when it starts.

    Args:
        motions: what messages say of the joints; at least one.
        plan: where each joint's motion comes from.
        joint_names: the robot's joints, in the order of the record's columns.
        found: all joints that the log names.
        notes: says which joints are held, fixed or worked out.

    Returns:
        The record, and the time of its first sample (in nanoseconds).

    Raises:
        LogError: a joint's motion isn't known.
    """
    times = np.unique(np.concatenate([m.times for m in motions]))
    columns: dict[str, _Column] = {}
    for name, in_log in plan.logged.items():
        having = [m for m in motions if in_log in m.names]
        if having:
            columns[name] = _column(in_log, having, times, notes)
    _add_the_rest(columns, plan, len(times), joint_names, notes)
    missing = [name for name in joint_names if name not in columns]
    if missing:
        wanted = [plan.logged[name] for name in missing]
        raise LogError(_why_missing(wanted, found, notes))
    chosen = [columns[name] for name in joint_names]
    velocities = [v for _, v in chosen if v is not None]
    record = JointRecord(
        names=tuple(joint_names),
        times=np.array([(t - times[0]) / 1e9 for t in times.tolist()]),
        positions=np.column_stack([q for q, _ in chosen]),
        velocities=np.column_stack(velocities)
        if len(velocities) == len(chosen)
        else None,
    )
    return record, int(times[0])


def _why_missing(
    wanted: Sequence[str], found: Sequence[str], notes: LogNotes
) -> str:
    """Returns why some joints have no motion: the log's names for them."""
    absent = [name for name in wanted if name not in found]
    if absent:
        return missing_joints(absent, tuple(found))
    said = f"no message that can be used has the joints {wanted}"
    return "; ".join([said, *notes.Sentences()])


def _column(
    name: str,
    motions: Sequence[JointMotion],
    times: np.ndarray,
    notes: LogNotes,
) -> _Column:
    """Returns what one joint does at the given times."""
    columns = [m.names.index(name) for m in motions]
    own = np.concatenate([m.times for m in motions])
    # Of equal times the first one counts.
    own, first = np.unique(own, return_index=True)
    pairs = list(zip(motions, columns, strict=True))
    q = np.concatenate([m.positions[:, i] for m, i in pairs])[first]
    velocities = [
        m.velocities[:, i] for m, i in pairs if m.velocities is not None
    ]
    v = (
        np.concatenate(velocities)[first]
        if len(velocities) == len(motions)
        else None
    )
    if len(own) == len(times):
        return q, v
    _say_if_held(name, own, times, notes)
    at, known = (times - times[0]) / 1e9, (own - times[0]) / 1e9
    return (
        np.interp(at, known, q),
        None if v is None else np.interp(at, known, v, left=0.0, right=0.0),
    )


def _say_if_held(
    name: str, own: np.ndarray, times: np.ndarray, notes: LogNotes
) -> None:
    for where, held in (
        ("before its first message", own[0] - times[0]),
        ("after its last message", times[-1] - own[-1]),
    ):
        if held > _MAX_HOLD * 1e9:
            notes.Add(
                f"the joint {name!r} is held for {held / 1e9:.2f} s {where}"
            )


def _add_the_rest(
    columns: dict[str, _Column],
    plan: JointPlan,
    count: int,
    joint_names: Sequence[str],
    notes: LogNotes,
) -> None:
    """Adds the joints that no message has."""
    for name, value in plan.fixed.items():
        columns[name] = np.full(count, float(value)), np.zeros(count)
    followers = [n for n in joint_names if n in plan.mimics]
    # A leader may itself follow another one.
    for _ in followers:
        for name in followers:
            mimic = plan.mimics[name]
            if name not in columns and mimic.leader in columns:
                q, v = columns[mimic.leader]
                columns[name] = (
                    mimic.multiplier * q + mimic.offset,
                    None if v is None else mimic.multiplier * v,
                )
                notes.Add(
                    f"no message has the joint {name!r}: it follows "
                    f"{mimic.leader!r}, as its model says"
                )
