"""What the messages of a log say, whatever their type."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pbpf_drake.bags.ros2_messages import (
    DETECTION_ARRAY,
    JOINT_STATE,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    TF_MESSAGE,
    TRANSFORM_STAMPED,
    pose_arrays,
    short_type_name,
    stamp_of,
    transform_arrays,
)
from pbpf_drake.config.log_topics import frame_name
from pbpf_drake.log.log_cleaning import JointSample, PoseSample


@dataclass(frozen=True)
class FramedPose:
    """A pose of something in some frame.

    Attributes:
        frame: what the pose is in; without ROS 1's leading slash.
        name: what it is the pose of, as the message says; may be empty.
        pose: the pose.
    """

    frame: str
    name: str
    pose: PoseSample


# One part of a message: its stamp (in nanoseconds), and what it says.
Sample = tuple[int, Any]


def extract_samples(kind: str, message: Any) -> list[Sample]:
    """Returns what a decoded message says.

    Args:
        kind: its type, one of those in the lists below.
        message: the decoded message.

    Returns:
        A JointSample with its stamp, or FramedPoses with theirs.
    """
    return _EXTRACT[short_type_name(kind)](message)


def _joint_state(message: Any) -> list[Sample]:
    sample = JointSample(
        tuple(message.name), message.position, message.velocity
    )
    return [(stamp_of(message.header), sample)]


def _pose_stamped(message: Any) -> list[Sample]:
    return [_framed(message.header, "", pose_arrays(message.pose))]


def _pose_with_covariance(message: Any) -> list[Sample]:
    return [_framed(message.header, "", pose_arrays(message.pose.pose))]


def _transform(message: Any) -> list[Sample]:
    arrays = transform_arrays(message.transform)
    name = frame_name(message.child_frame_id)
    return [_framed(message.header, name, arrays)]


def _tf(message: Any) -> list[Sample]:
    return [s for t in message.transforms for s in _transform(t)]


def _detections(message: Any) -> list[Sample]:
    return [
        _framed(message.header, *_best_result(d.results))
        for d in message.detections
    ]


def _best_result(
    results: Sequence[Any],
) -> tuple[str, tuple[np.ndarray, np.ndarray]]:
    if not results:
        return "", (np.zeros(4), np.zeros(3))
    # Before ROS 2 Humble a result had no hypothesis, and an id in its place.
    hypotheses = [getattr(result, "hypothesis", result) for result in results]
    best = max(range(len(results)), key=lambda i: hypotheses[i].score)
    class_id = getattr(hypotheses[best], "class_id", None)
    if class_id is None:
        class_id = hypotheses[best].id
    return str(class_id), pose_arrays(results[best].pose.pose)


def _framed(
    header: Any, name: str, arrays: tuple[np.ndarray, np.ndarray]
) -> Sample:
    frame = frame_name(header.frame_id)
    pose = FramedPose(frame, name, PoseSample(*arrays))
    return stamp_of(header), pose


_EXTRACT: dict[str, Callable[[Any], list[Sample]]] = {
    short_type_name(JOINT_STATE): _joint_state,
    short_type_name(POSE_STAMPED): _pose_stamped,
    short_type_name(POSE_WITH_COVARIANCE_STAMPED): _pose_with_covariance,
    short_type_name(TRANSFORM_STAMPED): _transform,
    short_type_name(DETECTION_ARRAY): _detections,
    short_type_name(TF_MESSAGE): _tf,
    # Its name before tf2.
    "tf/tfMessage": _tf,
}

_ONE_POSE = (POSE_STAMPED, POSE_WITH_COVARIANCE_STAMPED, TRANSFORM_STAMPED)
JOINT_TYPES = (JOINT_STATE,)
DETECTION_TYPES = (DETECTION_ARRAY, *_ONE_POSE)
TRUTH_TYPES = _ONE_POSE
TF_TYPES = (TF_MESSAGE, "tf/tfMessage")


def is_one_of(kind: str, types: Sequence[str]) -> bool:
    """Tells if a type is one of several."""
    return short_type_name(kind) in {short_type_name(t) for t in types}
