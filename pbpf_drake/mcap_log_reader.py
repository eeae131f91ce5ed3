"""Reads a log from an MCAP file of ROS 2 messages.

What can be used is used: messages that are damaged, not finite, twice there or
out of order cost no more than themselves, and the log's warnings count them.
A log that the filter can't run on is refused with a LogError.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
import numpy as np

from pbpf_drake.log import Log
from pbpf_drake.log_clock import RawStamped, Stamped, stamp_messages
from pbpf_drake.log_error import LogError
from pbpf_drake.log_notes import LogNotes
from pbpf_drake.log_records import (
    JointSample,
    PoseSample,
    make_detections,
    make_joint_record,
    make_pose_record,
)
from pbpf_drake.mcap_stream import McapStream, RawMessage
from pbpf_drake.ros2_messages import (
    DETECTION_ARRAY,
    JOINT_STATE,
    POSE_STAMPED,
    pose_arrays,
    short_type_name,
    stamp_of,
)
from pbpf_drake.scene import Scene


def ReadLog(
    *, filename: str | Path, scene: Scene, joint_names: Sequence[str]
) -> Log:
    """Reads what the filter needs of one recorded manipulation.

    Types and frames are those of WriteLog; ``scene.topics`` names the topics.
    A message's time is its header's stamp, or its log time where the stamp is
    zero. A detection is received at its log time, or at its stamp where the
    two are of different clocks.

    Args:
        filename: the MCAP file.
        scene: names topics, the joints in the log and the tracked objects.
        joint_names: the robot's joints in the model's order, which becomes
            the order of the log's columns.

    Returns:
        The log. Its ``warnings`` say what was left out. A log without
        detections is one of them.

    Raises:
        LogError: there is no such file, it isn't an MCAP file, a topic has
            messages of another type, or no joint state can be used.
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
        topics = scene.topics
        self._truth_topics = {
            name: topics.ground_truth + name for name in scene.tracked
        }
        self._types = {
            **{topic: POSE_STAMPED for topic in self._truth_topics.values()},
            topics.detections: DETECTION_ARRAY,
            topics.joint_states: JOINT_STATE,
        }
        self._stream = McapStream(filename=path, topics=self._types)
        self._decoders: dict[int, Callable[[bytes], Any] | None] = {}
        self._factory = DecoderFactory()
        self._notes = LogNotes()

    def Read(self) -> Log:
        raw: dict[str, list[RawStamped]] = {topic: [] for topic in self._types}
        for message in self._stream.Messages():
            self._CheckType(message)
            decoded = self._Decode(message)
            if decoded is not None:
                raw[message.topic].append(decoded)
        for sentence in self._stream.damage:
            self._notes.Add(sentence)
        joint_states = self._scene.topics.joint_states
        if not raw[joint_states]:
            raise LogError(self._NoJointStates())
        return self._MakeLog(
            stamp_messages(raw, reference=joint_states, notes=self._notes)
        )

    def _CheckType(self, message: RawMessage) -> None:
        expected = self._types[message.topic]
        schema = message.schema or Schema(id=0, data=b"", encoding="", name="")
        if short_type_name(schema.name) != short_type_name(expected):
            raise LogError(
                f"topic {message.topic} has messages of type {schema.name!r}; "
                f"expected {expected}"
            )
        encodings = (message.encoding, schema.encoding)
        if encodings != ("cdr", "ros2msg"):
            raise LogError(
                f"topic {message.topic} has messages encoded as "
                f"{encodings[0]} with a definition as {encodings[1]}; "
                "expected cdr with ros2msg, as ROS 2 records them"
            )

    def _Decode(self, message: RawMessage) -> RawStamped | None:
        """Returns what a message says, or None if it is damaged."""
        extract = _EXTRACT[self._types[message.topic]]
        try:
            decoded = self._Decoder(message)(message.data)
            stamp, value = stamp_of(decoded.header), extract(decoded)
        except Exception:  # Damage can show in any way.
            self._notes.Count(
                message.topic, "left out", "message", "that can't be decoded"
            )
            return None
        return RawStamped(message.log_time, stamp, value)

    def _Decoder(self, message: RawMessage) -> Callable[[bytes], Any]:
        assert message.schema is not None
        identifier = message.schema.id
        if identifier not in self._decoders:
            # A definition that can't be parsed is tried only once.
            self._decoders[identifier] = None
            self._decoders[identifier] = self._factory.decoder_for(
                message.encoding, message.schema
            )
        decoder = self._decoders[identifier]
        if decoder is None:
            raise LogError("no decoder")
        return decoder

    def _NoJointStates(self) -> str:
        topic = self._scene.topics.joint_states
        types = self._stream.types
        there = ", ".join(f"{t} ({types[t]})" for t in sorted(types))
        sentences = self._notes.Sentences()
        return (
            f"there are no joint states; expected {JOINT_STATE} on the topic "
            f"{topic}; the topics are: {there or 'none'}"
            + "".join(f"; {s}" for s in sentences)
        )

    def _MakeLog(self, messages: dict[str, list[Stamped]]) -> Log:
        topics, notes = self._scene.topics, self._notes
        joints, start = make_joint_record(
            messages[topics.joint_states],
            names=self._joint_names,
            topic=topics.joint_states,
            notes=notes,
        )
        detections = make_detections(
            _each_detection(messages[topics.detections]),
            names_by_class=self._scene.object_by_class(),
            start=start,
            topic=topics.detections,
            notes=notes,
        )
        if not detections:
            notes.Add(
                f"there are no detections of {self._scene.object_names()} on "
                f"the topic {topics.detections}: estimates stay at the "
                "scene's nominal poses"
            )
        truth = {
            name: make_pose_record(
                messages[topic], start=start, topic=topic, notes=notes
            )
            for name, topic in self._truth_topics.items()
        }
        known = {name: record for name, record in truth.items() if record}
        return Log(joints, detections, known, start, notes.Sentences())


def _joints_in_log(scene: Scene, joint_names: Sequence[str]) -> dict[str, str]:
    renamed = scene.topics.joint_names
    unknown = sorted(set(renamed) - set(joint_names))
    if unknown:
        raise LogError(
            f"the scene's topics.joint_names names {unknown}, which the robot "
            f"does not have; its joints are {list(joint_names)}"
        )
    return {name: renamed.get(name, name) for name in joint_names}


def _joint_sample(message: Any) -> JointSample:
    return JointSample(tuple(message.name), message.position, message.velocity)


def _detection_samples(message: Any) -> list[tuple[str, PoseSample]]:
    return [_detection_sample(d.results) for d in message.detections]


def _detection_sample(results: Sequence[Any]) -> tuple[str, PoseSample]:
    if not results:
        return "", PoseSample(np.zeros(4), np.zeros(3))
    # Before ROS 2 Humble a result had no hypothesis, and an id in its place.
    hypotheses = [getattr(result, "hypothesis", result) for result in results]
    best = max(range(len(results)), key=lambda i: hypotheses[i].score)
    class_id = getattr(hypotheses[best], "class_id", None)
    if class_id is None:
        class_id = hypotheses[best].id
    return str(class_id), PoseSample(*pose_arrays(results[best].pose.pose))


def _pose_sample(message: Any) -> PoseSample:
    return PoseSample(*pose_arrays(message.pose))


_EXTRACT: dict[str, Callable[[Any], Any]] = {
    JOINT_STATE: _joint_sample,
    DETECTION_ARRAY: _detection_samples,
    POSE_STAMPED: _pose_sample,
}


def _each_detection(messages: Sequence[Stamped]) -> list[Stamped]:
    return [
        Stamped(m.time, m.received, detection)
        for m in messages
        for detection in m.value
    ]
