"""What is in a log, whether the filter needs it or not."""

from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from pbpf_drake.bags.log_container import OpenLogStream
from pbpf_drake.bags.log_stream import RawMessage
from pbpf_drake.bags.message_decoder import MessageDecoder
from pbpf_drake.bags.ros2_messages import is_one_of
from pbpf_drake.log.sample_extraction import (
    DETECTION_TYPES,
    JOINT_TYPES,
    TF_TYPES,
    extract_joints,
    extract_poses,
)


@dataclass
class TopicSurvey:
    """What there is on one topic.

    Attributes:
        type: of its messages.
        count: of its messages.
        first, last: when they were received (in nanoseconds).
    """

    type: str
    count: int = 0
    first: int = 0
    last: int = 0

    def Add(self, time: int) -> None:
        """Counts one more message."""
        self.first = min(self.first, time) if self.count else time
        self.last = max(self.last, time) if self.count else time
        self.count += 1


@dataclass
class LogSurvey:
    """What there is in one log.

    Attributes:
        kind: what kind of file it is.
        topics: by name.
        frames: how often tf says where a frame is in its parent, by the
            names of the two.
        joints: names of joints, by topic.
        detection_frames: the frames that detections and single poses are in,
            by topic.
        damage: sentences on what can't be read.
        checksums: whether all that was read was covered by checksums.
    """

    kind: str = ""
    topics: dict[str, TopicSurvey] = field(default_factory=dict)
    frames: Counter[tuple[str, str]] = field(default_factory=Counter)
    joints: dict[str, set[str]] = field(default_factory=dict)
    detection_frames: dict[str, set[str]] = field(default_factory=dict)
    damage: list[str] = field(default_factory=list)
    checksums: bool = True


def SurveyLog(path: Path) -> LogSurvey:
    """Returns what is in a log.

    Args:
        path: the file or folder.

    Raises:
        LogError: it is no log.
    """
    stream, survey = OpenLogStream(path), LogSurvey()
    decoder = MessageDecoder(size=stream.size)
    for message in stream.Messages():
        topic = survey.topics.setdefault(
            message.topic, TopicSurvey(message.type)
        )
        topic.Add(message.log_time)
        try:
            _look_inside(message, decoder, survey)
        except Exception:  # Damage can show in any way; ReadLog counts it.
            continue
    for name, kind in stream.types.items():
        survey.topics.setdefault(name, TopicSurvey(kind))
    survey.kind, survey.damage = stream.kind, stream.damage
    survey.checksums = stream.checksums
    return survey


def _look_inside(
    message: RawMessage, decoder: MessageDecoder, survey: LogSurvey
) -> None:
    if is_one_of(message.type, TF_TYPES):
        for sample in extract_poses(message, decoder.Decode(message)):
            survey.frames[sample.value.name, sample.value.frame] += 1
    elif is_one_of(message.type, JOINT_TYPES):
        joints = extract_joints(message, decoder.Decode(message)).value
        survey.joints.setdefault(message.topic, set()).update(joints.names)
    elif is_one_of(message.type, DETECTION_TYPES):
        frames = survey.detection_frames.setdefault(message.topic, set())
        samples = extract_poses(message, decoder.Decode(message))
        frames.update(sample.value.frame for sample in samples)
