"""Reads the samples of a log's messages, whatever file they are in."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pbpf_drake.bags.log_container import OpenLogStream
from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.bags.log_stream import RawMessage
from pbpf_drake.bags.message_decoder import MessageDecoder
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, LimitError, ReadLimits
from pbpf_drake.bags.ros2_messages import is_one_of
from pbpf_drake.log.log_samples import JointSample, PoseSample, RawStamped
from pbpf_drake.log.sample_extraction import (
    JOINT_TYPES,
    extract_joints,
    extract_poses,
)

# The latest time that 64 bits with a sign can hold: in the year 2262 (in
# nanoseconds).
_MAX_TIME = 2**63 - 1


@dataclass(frozen=True)
class LogSamples:
    """What the messages of a log say, in the file's order.

    Attributes:
        poses: by topic; empty for a topic that has none.
        joints: the joint states by topic; empty for a topic that has none.
        counts: by topic, how many messages there are on it.
        types: of all topics in the file, the name of their messages' type.
    """

    poses: dict[str, list[RawStamped[PoseSample]]]
    joints: dict[str, list[RawStamped[JointSample]]]
    counts: Counter[str] = field(default_factory=Counter)
    types: dict[str, str] = field(default_factory=dict)


def ReadSamples(
    path: Path,
    types: Mapping[str, Sequence[str]],
    notes: LogNotes,
    limits: ReadLimits = DEFAULT_LIMITS,
) -> LogSamples:
    """Reads the samples on some topics of a log.

    Args:
        path: the file or folder.
        types: by topic, the types that its messages may have.
        notes: counts the messages that are damaged, and says what else is.
        limits: what the file may hold at most.

    Raises:
        LogError: it is no log, or a topic has messages of another type.
    """
    stream = OpenLogStream(path, types, limits)
    decoder = MessageDecoder(limits, stream.size)
    # By topic, why a message on it can't be what the scene asks for.
    misfits: dict[str, str] = {}
    fitting: set[str] = set()
    samples = LogSamples(
        poses={topic: [] for topic in types},
        joints={topic: [] for topic in types},
    )
    for message in stream.Messages():
        samples.counts[message.topic] += 1
        counts = notes.On(message.topic, "message")
        misfit = _misfit(message, types[message.topic])
        if misfit:
            misfits.setdefault(message.topic, misfit)
            counts.CountLeftOut(misfit)
            continue
        fitting.add(message.topic)
        try:
            _add(samples, message, decoder)
        except LimitError as error:
            counts.CountLeftOut(str(error))
        except Exception:  # Damage can show in any way.
            counts.CountLeftOut("that can't be decoded")
    for topic, misfit in misfits.items():
        if topic not in fitting:
            raise LogError(f"topic {topic} has messages {misfit}")
    for sentence in (*stream.damage, *decoder.Sentences()):
        notes.Add(sentence)
    samples.types.update(stream.types)
    return samples


def joint_names_of(samples: LogSamples) -> set[str]:
    """Returns the names of all joints in some samples."""
    return {
        name
        for on_topic in samples.joints.values()
        for sample in on_topic
        for name in sample.value.names
    }


def _misfit(message: RawMessage, expected: Sequence[str]) -> str:
    """Returns why a message can't be used, as in "messages of ..."."""
    wanted = f"; expected {' or '.join(expected)}"
    if message.encoding not in ("cdr", "ros1"):
        return (
            f"encoded as {message.encoding!r}; expected cdr or ros1, as ROS 2 "
            "and ROS 1 record them"
        )
    if not message.type:
        return (
            "of a type that the file does not name, and that is none of those "
            f"known{wanted}: record it where the type's package is installed"
        )
    if not is_one_of(message.type, expected):
        return f"of type {message.type!r}{wanted}"
    return ""


def _add(
    samples: LogSamples, message: RawMessage, decoder: MessageDecoder
) -> None:
    """Adds what a message says; nothing if it is damaged, which raises."""
    if message.log_time > _MAX_TIME:
        raise ValueError("the time can't be")
    decoded = decoder.Decode(message)
    if is_one_of(message.type, JOINT_TYPES):
        joints = extract_joints(message, decoded)
        samples.joints[message.topic].append(joints)
    else:
        samples.poses[message.topic] += extract_poses(message, decoded)
