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
    path: Path, types: Mapping[str, Sequence[str]], notes: LogNotes
) -> LogSamples:
    """Reads the samples on some topics of a log.

    Args:
        path: the file or folder.
        types: by topic, the types that its messages may have.
        notes: counts the messages that are damaged, and says what else is.

    Raises:
        LogError: it is no log, or a topic has messages of another type.
    """
    stream, decoder = OpenLogStream(path, types), MessageDecoder()
    samples = LogSamples(
        poses={topic: [] for topic in types},
        joints={topic: [] for topic in types},
    )
    for message in stream.Messages():
        samples.counts[message.topic] += 1
        _check_type(message, types[message.topic])
        try:
            _add(samples, message, decoder)
        except Exception:  # Damage can show in any way.
            counts = notes.On(message.topic, "message")
            counts.CountLeftOut("that can't be decoded")
    for sentence in stream.damage:
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


def _check_type(message: RawMessage, expected: Sequence[str]) -> None:
    if not is_one_of(message.type, expected):
        raise LogError(
            f"topic {message.topic} has messages of type {message.type!r}"
            f"; expected {' or '.join(expected)}"
        )
    if message.encoding not in ("cdr", "ros1"):
        raise LogError(
            f"topic {message.topic} has messages encoded as "
            f"{message.encoding!r}; expected cdr or ros1, as ROS 2 and "
            "ROS 1 record them"
        )


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
