"""Sorts joint states by the joints they have, without what can't be used."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
import math

import numpy as np

from pbpf_drake.bags.log_notes import TopicNotes, plural
from pbpf_drake.log.log_jumps import find_spikes, without_jumps
from pbpf_drake.log.log_samples import JointSample, Stamped
from pbpf_drake.log.stamp_order import gap_clause, in_stamp_order, seconds_since


@dataclass(frozen=True)
class JointMotion:
    """How some joints moved, as messages say that have just these.

    Attributes:
        names: of m joints in the log.
        times: (N,) strictly increasing (in nanoseconds since the epoch).
        positions: (N, m) all finite (in radians or meters).
        velocities: (N, m) all finite (in rad/s or m/s), or None where one is
            missing.
    """

    names: tuple[str, ...]
    times: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray | None


def joint_motions(
    messages: Sequence[Stamped[JointSample]],
    *,
    wanted: Sequence[str],
    notes: TopicNotes,
) -> list[JointMotion]:
    """Returns what the messages of one topic say of the wanted joints.

    Drivers of arm and gripper may share a topic, so a message may have any of
    the joints. There is one motion for each set of them.

    Args:
        messages: as they were received.
        wanted: names of the robot's joints in the log.
        notes: counts what is left out.
    """
    by_joints: dict[tuple[str, ...], list[Stamped[JointSample]]] = {}
    not_finite: Counter[str] = Counter()
    others: set[str] = set()
    # Most messages have the same names.
    wanted_of: dict[tuple[str, ...], tuple[str, ...]] = {}
    for message in messages:
        sample = message.value
        if sample.names not in wanted_of:
            has = set(sample.names)
            wanted_of[sample.names] = tuple(n for n in wanted if n in has)
        names = wanted_of[sample.names]
        reason = _problem(sample, names, wanted)
        if not reason:
            bad = _not_finite(sample, names)
            not_finite.update(bad)
            reason = "whose field position is not finite" if bad else ""
        if reason:
            notes.CountLeftOut(reason)
        else:
            others.update(sample.names)
            by_joints.setdefault(names, []).append(message)
    _say_which(not_finite, others - set(wanted), notes)
    return [_motion(names, m, notes) for names, m in by_joints.items()]


def _problem(
    sample: JointSample, names: Sequence[str], wanted: Sequence[str]
) -> str:
    """Returns why a sample can't be used, as a clause; empty if it can."""
    if len(sample.positions) != len(sample.names):
        return (
            f"whose field position has {len(sample.positions)} values for "
            f"{len(sample.names)} names"
        )
    if not names:
        return f"without the joints {list(wanted)}; joints are {sample.names}"
    return ""


def _not_finite(sample: JointSample, names: Sequence[str]) -> list[str]:
    values = _pick(sample, sample.positions, names)
    return [
        n for n, v in zip(names, values, strict=True) if not math.isfinite(v)
    ]


def _say_which(
    not_finite: Mapping[str, int], others: set[str], notes: TopicNotes
) -> None:
    for name, count in not_finite.items():
        notes.Add(
            f"the joint {name!r} is not finite {plural(count, 'time')}; if "
            "nobody measures it, give it a position in topics.fixed_joints"
        )
    if others:
        notes.Add(
            f"ignored the joints {sorted(others)}, which are not the robot's "
            "or are fixed by the scene"
        )


def _motion(
    names: tuple[str, ...],
    messages: Sequence[Stamped[JointSample]],
    notes: TopicNotes,
) -> JointMotion:
    kept = in_stamp_order(messages, notes)
    kept = without_jumps(kept, _positions(kept, names), notes, names)
    positions = _positions(kept, names)
    seconds = seconds_since(messages[0].time, kept)
    if gap := gap_clause(seconds - seconds[0]):
        notes.Add(f"{gap}; joints are taken to move evenly from end to end")
    for sentence in _spikes(names, positions, seconds - seconds[0]):
        notes.Add(sentence)
    return JointMotion(
        names=names,
        times=np.array([m.time for m in kept], dtype=np.int64),
        positions=positions,
        velocities=_velocities(kept, names),
    )


def _spikes(
    names: Sequence[str], positions: np.ndarray, times: np.ndarray
) -> list[str]:
    """Returns a sentence for each joint that jumps and comes back."""
    found = find_spikes(positions)
    sentences = []
    for j, name in enumerate(names):
        at = [i for i, joint in found if joint == j]
        if at:
            steps = np.abs(positions[at, j] - positions[np.array(at) - 1, j])
            widest = int(np.argmax(steps))
            sentences.append(
                f"the joint {name!r} jumps and comes back within one sample "
                f"{plural(len(at), 'time')}, by up to {steps[widest]:.3g} rad "
                f"or m at {times[at[widest]]:.3f} s: it was used, but may be "
                "damaged"
            )
    return sentences


def _pick(
    sample: JointSample, values: Sequence[float], names: Sequence[str]
) -> list[float]:
    """Returns the values of some joints, in their order."""
    return [values[sample.names.index(name)] for name in names]


def _positions(
    messages: Sequence[Stamped[JointSample]], names: Sequence[str]
) -> np.ndarray:
    samples = [m.value for m in messages]
    return np.array([_pick(s, s.positions, names) for s in samples])


def _velocities(
    messages: Sequence[Stamped[JointSample]], names: Sequence[str]
) -> np.ndarray | None:
    """Returns the velocities, or None unless every message has them all."""
    samples = [m.value for m in messages]
    if any(len(s.velocities) != len(s.names) for s in samples):
        return None
    rows = np.array([_pick(s, s.velocities, names) for s in samples])
    return rows if np.all(np.isfinite(rows)) else None
