"""Makes samples of decoded messages, whatever type of message they are."""

from collections.abc import Callable
from typing import Any

import numpy as np

from pbpf_drake.bags.log_stream import RawMessage
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
from pbpf_drake.log.log_samples import JointSample, PoseSample, RawStamped

# The types that messages of each kind may have.
JOINT_TYPES = (JOINT_STATE,)
TRUTH_TYPES = (POSE_STAMPED, POSE_WITH_COVARIANCE_STAMPED, TRANSFORM_STAMPED)
DETECTION_TYPES = (DETECTION_ARRAY, *TRUTH_TYPES)
# The second one is its name before tf2.
TF_TYPES = (TF_MESSAGE, "tf/tfMessage")

_Arrays = tuple[np.ndarray, np.ndarray]
# A part of a message: its decoded header, and the pose that it says.
_Part = tuple[Any, PoseSample]


def extract_joints(
    message: RawMessage, decoded: Any
) -> RawStamped[JointSample]:
    """Returns what a message of one of JOINT_TYPES says.

    Args:
        message: as the file holds it.
        decoded: the same message, with its fields as attributes.
    """
    sample = JointSample(
        tuple(decoded.name), decoded.position, decoded.velocity
    )
    return RawStamped(message.log_time, stamp_of(decoded.header), sample)


def extract_poses(
    message: RawMessage, decoded: Any
) -> list[RawStamped[PoseSample]]:
    """Returns what a message of any other of the types above says.

    Args:
        message: as the file holds it.
        decoded: the same message, with its fields as attributes.
    """
    extract = _EXTRACT[short_type_name(message.type)]
    return [
        RawStamped(message.log_time, stamp_of(header), sample)
        for header, sample in extract(decoded)
    ]


def _pose_stamped(message: Any) -> list[_Part]:
    return [_part(message.header, "", pose_arrays(message.pose))]


def _pose_with_covariance(message: Any) -> list[_Part]:
    return [_part(message.header, "", pose_arrays(message.pose.pose))]


def _transform(message: Any) -> list[_Part]:
    name = frame_name(message.child_frame_id)
    return [_part(message.header, name, transform_arrays(message.transform))]


def _tf(message: Any) -> list[_Part]:
    return [part for t in message.transforms for part in _transform(t)]


def _detections(message: Any) -> list[_Part]:
    return [
        (message.header, _detection(frame_name(message.header.frame_id), d))
        for d in message.detections
    ]


def _detection(frame: str, detection: Any) -> PoseSample:
    """Returns the result of the highest score.

    Some detectors fill in only the bounding box, and leave the pose of the
    result at zero.
    """
    results = detection.results
    if not results:
        return PoseSample(frame, "", np.zeros(4), np.zeros(3))
    # Before ROS 2 Humble a result had no hypothesis, and an id in its place.
    hypotheses = [getattr(result, "hypothesis", result) for result in results]
    best = max(range(len(results)), key=lambda i: hypotheses[i].score)
    class_id = getattr(hypotheses[best], "class_id", None)
    if class_id is None:
        class_id = hypotheses[best].id
    score = float(hypotheses[best].score)
    q, p = pose_arrays(results[best].pose.pose)
    is_of_bbox = False
    if _is_empty(q, p) and hasattr(detection, "bbox"):
        box_q, box_p = pose_arrays(detection.bbox.center)
        if not _is_empty(box_q, box_p):
            q, p, is_of_bbox = box_q, box_p, True
    return PoseSample(frame, str(class_id), q, p, score, is_of_bbox)


def _is_empty(q: np.ndarray, p: np.ndarray) -> bool:
    """Tells if a pose is what an empty message has: zero or identity."""
    return not np.any(p) and not np.any(q[1:])


def _part(header: Any, name: str, arrays: _Arrays) -> _Part:
    return header, PoseSample(frame_name(header.frame_id), name, *arrays)


_EXTRACT: dict[str, Callable[[Any], list[_Part]]] = {
    short_type_name(kind): extract
    for kind, extract in (
        (POSE_STAMPED, _pose_stamped),
        (POSE_WITH_COVARIANCE_STAMPED, _pose_with_covariance),
        (TRANSFORM_STAMPED, _transform),
        (DETECTION_ARRAY, _detections),
        *((kind, _tf) for kind in TF_TYPES),
    )
}
