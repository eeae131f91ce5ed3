"""Reads a log, whatever file it is in.

A file is opened by its container's stream, its messages are decoded, and what
they say becomes records. What can be used is used: messages that are damaged,
not finite, twice there or out of order cost no more than themselves, and the
log's warnings count them. A log that the filter can't run on is refused with a
LogError.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from pbpf_drake.bags.log_container import OpenLogStream
from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.bags.log_stream import RawMessage
from pbpf_drake.bags.message_decoder import MessageDecoder
from pbpf_drake.bags.ros2_messages import DETECTION_ARRAY
from pbpf_drake.config.log_topics import is_frame
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.log_cleaning import (
    is_usable,
    make_detections,
    make_joint_record,
    make_pose_record,
)
from pbpf_drake.log.log_clock import RawStamped, Stamped, stamp_messages
from pbpf_drake.log.log_frames import LogFrames
from pbpf_drake.log.log_records import DetectionRecord, Log, PoseRecord
from pbpf_drake.log.log_samples import extract_samples, is_one_of
from pbpf_drake.log.log_sources import ANY, LogSources, from_source
from pbpf_drake.log.tf_joints import tf_joint_samples
from pbpf_drake.log.transform_tree import TransformTree, make_transform_tree

_ARRAYS = (DETECTION_ARRAY,)
# Of 64 bits with a sign (in nanoseconds), which is in the year 2262.
_MAX_TIME = 2**63 - 1
_Timed = TypeVar("_Timed", RawStamped, Stamped)


def ReadLog(
    *, filename: str | Path, scene: Scene, joint_names: Sequence[str]
) -> Log:
    """Reads what the filter needs of one recorded manipulation.

    ``scene.topics`` says where that is. A message's time is its header's
    stamp, or its log time where the stamp is zero. A detection is received at
    its log time, or at its stamp where the two are of different clocks.

    Args:
        filename: an MCAP file, a ROS 1 bag, or a ROS 2 bag or its folder.
        scene: names topics, frames, the joints in the log and the objects.
        joint_names: the robot's joints in the model's order, which becomes
            the order of the log's columns.

    Returns:
        The log. Its ``warnings`` say what was left out. A log without
        detections is one of them.

    Raises:
        LogError: there is no such file, it isn't a log, a topic has messages
            of another type, or no joint state can be used.
    """
    path = Path(filename).expanduser()
    try:
        return _LogReader(path, scene, joint_names).Read()
    except LogError as error:
        raise LogError(f"Log {path}: {error}") from error


class _LogReader:
    """Everything that is known while one file is read."""

    def __init__(self, path: Path, scene: Scene, joint_names: Sequence[str]):
        self._scene = scene
        self._joint_names = _joints_in_log(scene, joint_names)
        self._sources = LogSources(scene)
        self._stream = OpenLogStream(path, self._sources.types)
        self._decoder = MessageDecoder()
        self._notes = LogNotes()

    def Read(self) -> Log:
        raw: dict[str, list[RawStamped]] = {t: [] for t in self._sources.types}
        for message in self._stream.Messages():
            self._CheckType(message)
            raw[message.topic] += self._Decode(message)
        for sentence in self._stream.damage:
            self._notes.Add(sentence)
        reference = self._sources.joints
        if not raw[reference]:
            raise LogError(self._NoJointStates())
        # Latched long before the log, and true at all times.
        static = raw.pop(self._scene.topics.tf_static, [])
        messages = stamp_messages(raw, reference=reference, notes=self._notes)
        topics, notes = self._scene.topics, self._notes
        tree = make_transform_tree(
            _usable(messages.get(topics.tf, []), topics.tf, notes),
            _usable(static, topics.tf_static, notes),
            notes=notes,
        )
        return self._MakeLog(messages, tree)

    def _CheckType(self, message: RawMessage) -> None:
        expected = self._sources.types[message.topic]
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

    def _Decode(self, message: RawMessage) -> list[RawStamped]:
        """Returns what a message says; nothing if it is damaged."""
        try:
            if message.log_time > _MAX_TIME:
                raise ValueError("the time can't be")
            decoded = self._decoder.Decode(message)
            samples = extract_samples(message.type, decoded)
        except Exception:  # Damage can show in any way.
            self._notes.Count(
                message.topic, "left out", "message", "that can't be decoded"
            )
            return []
        return [
            RawStamped(message.log_time, stamp, value)
            for stamp, value in samples
        ]

    def _NoJointStates(self) -> str:
        types = self._stream.types
        there = ", ".join(f"{t} ({types[t]})" for t in sorted(types))
        topic = self._sources.joints
        expected = " or ".join(self._sources.types[topic])
        return (
            f"there are no joint states; expected {expected} on the topic "
            f"{topic}; the topics are: {there or 'none'}"
            + "".join(f"; {s}" for s in self._notes.Sentences())
        )

    def _MakeLog(
        self, messages: dict[str, list[Stamped]], tree: TransformTree
    ) -> Log:
        topics, notes = self._scene.topics, self._notes
        base = messages.get(topics.ground_truth_base, [])
        frames = LogFrames(
            topics=topics,
            tree=tree,
            base=_usable(base, topics.ground_truth_base, notes),
            camera=self._scene.camera.pose(),
            notes=notes,
        )
        joints = messages[self._sources.joints]
        if topics.tf_joints:
            joints = tf_joint_samples(tree, topics, list(self._joint_names))
        record, start = make_joint_record(
            joints,
            names=self._joint_names,
            topic=self._sources.joints,
            notes=notes,
        )
        detections = self._Detections(messages, frames, start)
        truth = self._GroundTruth(messages, frames, start)
        return Log(
            record, detections, truth, start, notes.Sentences(), frames.X_WC
        )

    def _Detections(
        self, messages: dict[str, list[Stamped]], frames: LogFrames, start: int
    ) -> tuple[DetectionRecord, ...]:
        topics = self._scene.topics
        found: list[DetectionRecord] = []
        for source, name in self._sources.detections.items():
            # An array names its objects, also on a topic for one of them.
            if is_one_of(self._stream.types.get(source, ""), _ARRAYS):
                name = ANY
            seen = from_source(messages, source, topics.tf)
            found += make_detections(
                [
                    replace(m, value=(self._ClassId(m, name), m.value.pose))
                    for m in frames.InCamera(seen, source)
                ],
                names_by_class=self._scene.object_by_class(),
                start=start,
                topic=source,
                notes=self._notes,
            )
        if not found:
            kind = "in" if is_frame(topics.detections) else "on the topic"
            self._notes.Add(
                f"there are no detections of {self._scene.object_names()} "
                f"{kind} {topics.detections}: estimates stay at the scene's "
                "nominal poses"
            )
        return tuple(sorted(found, key=lambda d: (d.received, d.time, d.name)))

    def _ClassId(self, message: Stamped, name: str) -> str:
        if name == ANY:
            return message.value.name
        return self._scene.tracked[name].class_id or name

    def _GroundTruth(
        self, messages: dict[str, list[Stamped]], frames: LogFrames, start: int
    ) -> dict[str, PoseRecord]:
        found = {}
        for name, source in self._sources.ground_truth.items():
            poses = self._sources.Truth(
                from_source(messages, source, self._scene.topics.tf), name
            )
            record = make_pose_record(
                [
                    replace(m, value=m.value.pose)
                    for m in frames.InWorld(poses, source)
                ],
                start=start,
                topic=source,
                notes=self._notes,
            )
            if record:
                found[name] = record
        return found


def _joints_in_log(scene: Scene, joint_names: Sequence[str]) -> dict[str, str]:
    renamed = scene.topics.joint_names
    unknown = sorted(set(renamed) - set(joint_names))
    if unknown:
        raise LogError(
            f"the scene's topics.joint_names names {unknown}, which the robot "
            f"does not have; its joints are {list(joint_names)}"
        )
    if scene.topics.tf_joints:
        return {name: name for name in joint_names}
    return {name: renamed.get(name, name) for name in joint_names}


def _usable(
    messages: Sequence[_Timed], topic: str, notes: LogNotes
) -> list[_Timed]:
    """Returns the messages whose FramedPoses can be used."""
    return [
        m
        for m in messages
        if is_usable(m.value.pose, topic, "transform", notes)
    ]
