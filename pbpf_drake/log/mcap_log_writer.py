"""Writes a log as an MCAP file of ROS 2 messages."""

from collections.abc import Iterator, Mapping
from itertools import groupby
from pathlib import Path
from typing import Any

from mcap_ros2.writer import Writer
import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.bags.ros2_messages import (
    DETECTION_ARRAY,
    JOINT_STATE,
    POSE_STAMPED,
    header_message,
    message_definition,
    pose_message,
    to_nanoseconds,
)
from pbpf_drake.config.log_topics import LogTopics, for_object, is_frame
from pbpf_drake.log.log_records import DetectionRecord, Log

CAMERA_FRAME = "camera_color_optical_frame"
WORLD_FRAME = "world"

# A file that is cut off loses its last chunk: a small chunk loses little.
CHUNK_SIZE = 64 * 1024

# When it was received (in nanoseconds), topic, type, message.
_Entry = tuple[int, str, str, dict[str, Any]]


def WriteLog(
    *,
    filename: str | Path,
    scene_topics: LogTopics,
    log: Log,
    class_ids: Mapping[str, str] | None = None,
) -> None:
    """Writes a log that ReadLog, `ros2 bag` and Foxglove open.

    Joint states, detections (in the frame "camera_color_optical_frame") and
    ground truth (in "world") go to the scene's topics. A header's stamp is
    when something was, the message's log time is when it was received. Times
    are kept to the nanosecond, all other numbers to the bit, except for the
    rotations of detections, which become quaternions. The same log always
    gives the same bytes. Warnings of the log are not written.

    Args:
        filename: the file to write; its folder must exist.
        scene_topics: the names of topics, and of joints in the log.
        log: what to write.
        class_ids: the detector's class names by the names of tracked models,
            where they differ.

    Raises:
        ValueError: a time of the log is not after the epoch. ROS reads the
            stamp zero as none, so set ``log.start_time``. Or the scene's
            topics are frames of tf.
    """
    entries = log_entries(log, scene_topics, class_ids or {})
    with Writer(str(filename), chunk_size=CHUNK_SIZE) as writer:
        schemas = {
            name: writer.register_msgdef(name, message_definition(name))
            for name in (JOINT_STATE, DETECTION_ARRAY, POSE_STAMPED)
        }
        for log_time, topic, name, message in entries:
            writer.write_message(
                topic=topic,
                schema=schemas[name],
                message=message,
                log_time=log_time,
            )


def log_entries(
    log: Log, topics: LogTopics, class_ids: Mapping[str, str]
) -> list[_Entry]:
    """Returns the messages that WriteLog writes, as they were received.

    Args:
        log, topics, class_ids: see WriteLog.
    """
    sources = (topics.detections, topics.ground_truth)
    if topics.tf_joints or any(is_frame(source) for source in sources):
        raise ValueError(
            f"topics of the preset {topics.preset!r} are partly in tf; "
            "expected topics for joint states, detections and ground truth"
        )
    entries = [
        *_joint_states(topics, log),
        *_detections(topics, log, class_ids),
        *_ground_truth(topics, log),
    ]
    _check_stamps(log, entries)
    # Sorting is stable: what was received at once stays in this order.
    return sorted(entries, key=lambda entry: entry[0])


def _joint_states(topics: LogTopics, log: Log) -> Iterator[_Entry]:
    joints = log.joints
    names = [topics.joint_names.get(name, name) for name in joints.names]
    for i, time in enumerate(joints.times):
        stamp = to_nanoseconds(start_time=log.start_time, time=time)
        message = {
            "header": header_message(stamp=stamp, frame_id=""),
            "name": names,
            "position": joints.positions[i].tolist(),
        }
        if joints.velocities is not None:
            message["velocity"] = joints.velocities[i].tolist()
        yield stamp, topics.joint_states, JOINT_STATE, message


def _detections(
    topics: LogTopics, log: Log, class_ids: Mapping[str, str]
) -> Iterator[_Entry]:
    def times(detection: DetectionRecord) -> tuple[int, int]:
        return (
            to_nanoseconds(start_time=log.start_time, time=detection.received),
            to_nanoseconds(start_time=log.start_time, time=detection.time),
        )

    # What was seen in one image and received at once is one message.
    ordered = sorted(log.detections, key=times)
    for (received, stamp), group in groupby(ordered, key=times):
        header = header_message(stamp=stamp, frame_id=CAMERA_FRAME)
        message = {
            "header": header,
            "detections": [
                _detection(header, class_ids.get(d.name, d.name), d.X_CO)
                for d in group
            ],
        }
        yield received, topics.detections, DETECTION_ARRAY, message


def _detection(
    header: dict[str, Any], class_id: str, X_CO: RigidTransform
) -> dict[str, Any]:
    pose = pose_message(
        q=X_CO.rotation().ToQuaternion().wxyz(), p=X_CO.translation()
    )
    return {
        "header": header,
        "results": [
            {
                "hypothesis": {"class_id": class_id, "score": 1.0},
                "pose": {"pose": pose, "covariance": np.zeros(36).tolist()},
            }
        ],
        "bbox": {"center": pose},
    }


def _ground_truth(topics: LogTopics, log: Log) -> Iterator[_Entry]:
    for name, record in log.ground_truth.items():
        topic = for_object(topics.ground_truth, name)
        for i, time in enumerate(record.times):
            stamp = to_nanoseconds(start_time=log.start_time, time=time)
            message = {
                "header": header_message(stamp=stamp, frame_id=WORLD_FRAME),
                "pose": pose_message(q=record.q_WO[i], p=record.p_WO[i]),
            }
            yield stamp, topic, POSE_STAMPED, message


def _check_stamps(log: Log, entries: list[_Entry]) -> None:
    for _, topic, _, message in entries:
        stamp = message["header"]["stamp"]
        if stamp["sec"] < 0 or stamp == {"sec": 0, "nanosec": 0}:
            raise ValueError(
                f"log.start_time is {log.start_time} ns, which puts a stamp "
                f"on {topic} at or before zero; expected a time since the "
                "epoch that makes all stamps positive, for in ROS a stamp of "
                "zero means none"
            )
