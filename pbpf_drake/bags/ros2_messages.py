"""ROS 2 message definitions, and messages as dictionaries.

An MCAP file carries the definition of every message type in it. These are the
types that this project reads and writes, in the layout of ROS 2 Humble. The
writer of mcap_ros2 takes messages as nested dictionaries.
"""

from collections.abc import Collection
from typing import Any

import numpy as np

JOINT_STATE = "sensor_msgs/msg/JointState"
IMAGE = "sensor_msgs/msg/Image"
COMPRESSED_IMAGE = "sensor_msgs/msg/CompressedImage"
DETECTION_ARRAY = "vision_msgs/msg/Detection3DArray"
POSE_STAMPED = "geometry_msgs/msg/PoseStamped"
POSE_WITH_COVARIANCE_STAMPED = "geometry_msgs/msg/PoseWithCovarianceStamped"
POSE_ARRAY = "geometry_msgs/msg/PoseArray"
TRANSFORM_STAMPED = "geometry_msgs/msg/TransformStamped"
TF_MESSAGE = "tf2_msgs/msg/TFMessage"

_FIELDS = {
    "builtin_interfaces/Time": ("int32 sec", "uint32 nanosec"),
    "std_msgs/Header": ("builtin_interfaces/Time stamp", "string frame_id"),
    "geometry_msgs/Point": ("float64 x", "float64 y", "float64 z"),
    "geometry_msgs/Vector3": ("float64 x", "float64 y", "float64 z"),
    "geometry_msgs/Quaternion": (
        "float64 x 0",
        "float64 y 0",
        "float64 z 0",
        "float64 w 1",
    ),
    "geometry_msgs/Pose": (
        "geometry_msgs/Point position",
        "geometry_msgs/Quaternion orientation",
    ),
    "geometry_msgs/PoseWithCovariance": (
        "geometry_msgs/Pose pose",
        "float64[36] covariance",
    ),
    "geometry_msgs/PoseStamped": (
        "std_msgs/Header header",
        "geometry_msgs/Pose pose",
    ),
    "geometry_msgs/PoseWithCovarianceStamped": (
        "std_msgs/Header header",
        "geometry_msgs/PoseWithCovariance pose",
    ),
    "geometry_msgs/PoseArray": (
        "std_msgs/Header header",
        "geometry_msgs/Pose[] poses",
    ),
    "geometry_msgs/Transform": (
        "geometry_msgs/Vector3 translation",
        "geometry_msgs/Quaternion rotation",
    ),
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header",
        "string child_frame_id",
        "geometry_msgs/Transform transform",
    ),
    "tf2_msgs/TFMessage": ("geometry_msgs/TransformStamped[] transforms",),
    "sensor_msgs/JointState": (
        "std_msgs/Header header",
        "string[] name",
        "float64[] position",
        "float64[] velocity",
        "float64[] effort",
    ),
    "sensor_msgs/Image": (
        "std_msgs/Header header",
        "uint32 height",
        "uint32 width",
        "string encoding",
        "uint8 is_bigendian",
        "uint32 step",
        "uint8[] data",
    ),
    "sensor_msgs/CompressedImage": (
        "std_msgs/Header header",
        "string format",
        "uint8[] data",
    ),
    "vision_msgs/ObjectHypothesis": ("string class_id", "float64 score"),
    "vision_msgs/ObjectHypothesisWithPose": (
        "vision_msgs/ObjectHypothesis hypothesis",
        "geometry_msgs/PoseWithCovariance pose",
    ),
    "vision_msgs/BoundingBox3D": (
        "geometry_msgs/Pose center",
        "geometry_msgs/Vector3 size",
    ),
    "vision_msgs/Detection3D": (
        "std_msgs/Header header",
        "vision_msgs/ObjectHypothesisWithPose[] results",
        "vision_msgs/BoundingBox3D bbox",
        "string id",
    ),
    "vision_msgs/Detection3DArray": (
        "std_msgs/Header header",
        "vision_msgs/Detection3D[] detections",
    ),
}


# Their layout is the same in all releases of ROS 2.
_STABLE = {
    "geometry_msgs/PoseStamped",
    "geometry_msgs/PoseWithCovarianceStamped",
    "geometry_msgs/TransformStamped",
    "sensor_msgs/JointState",
    "tf2_msgs/TFMessage",
}


def is_known(name: str) -> bool:
    """Tells if this module has the definition of a type."""
    return short_type_name(name) in _FIELDS


def is_stable(name: str) -> bool:
    """Tells if a type is known and the same in all releases of ROS 2."""
    return short_type_name(name) in _STABLE


def short_type_name(name: str) -> str:
    """Returns "package/Type" for "package/msg/Type" or itself."""
    return name.replace("/msg/", "/")


def is_one_of(name: str, types: Collection[str]) -> bool:
    """Tells if a type is one of several."""
    return short_type_name(name) in {short_type_name(t) for t in types}


def message_definition(name: str) -> str:
    """Returns the text of a type and of all types in it, as in ROS 2 bags.

    Args:
        name: one of this module's types, such as JOINT_STATE.
    """
    names = [short_type_name(name)]
    for parent in names:  # Grows while it is walked.
        for line in _FIELDS[parent]:
            child = line.split()[0].removesuffix("[]")
            if child in _FIELDS and child not in names:
                names.append(child)
    texts = ["\n".join(_FIELDS[names[0]])]
    texts += [f"MSG: {n}\n" + "\n".join(_FIELDS[n]) for n in names[1:]]
    return ("\n" + "=" * 80 + "\n").join(texts)


def to_nanoseconds(*, start_time: int, time: float) -> int:
    """Returns the time since the epoch (in nanoseconds).

    Args:
        start_time: what ``time`` is relative to (in nanoseconds).
        time: a time in a log (in seconds).
    """
    return start_time + round(float(time) * 1e9)


def header_message(*, stamp: int, frame_id: str) -> dict[str, Any]:
    """Returns a std_msgs/Header; ``stamp`` is in nanoseconds."""
    sec, nanosec = divmod(stamp, 10**9)
    return {"stamp": {"sec": sec, "nanosec": nanosec}, "frame_id": frame_id}


def stamp_of(header: Any) -> int:
    """Returns the stamp of a decoded std_msgs/Header (in nanoseconds)."""
    return header.stamp.sec * 10**9 + header.stamp.nanosec


def pose_message(*, q: np.ndarray, p: np.ndarray) -> dict[str, Any]:
    """Returns a geometry_msgs/Pose.

    Args:
        q: (4,) quaternion w, x, y, z.
        p: (3,) position (in meters).
    """
    return {
        "position": dict(zip("xyz", p, strict=True)),
        "orientation": dict(zip("wxyz", q, strict=True)),
    }


def transform_arrays(transform: Any) -> tuple[np.ndarray, np.ndarray]:
    """Returns q (4,) as w, x, y, z and p (3,) of a decoded Transform."""
    q, p = transform.rotation, transform.translation
    return np.array([q.w, q.x, q.y, q.z]), np.array([p.x, p.y, p.z])


def pose_arrays(pose: Any) -> tuple[np.ndarray, np.ndarray]:
    """Returns q (4,) as w, x, y, z and p (3,) of a decoded Pose."""
    q, p = pose.orientation, pose.position
    return np.array([q.w, q.x, q.y, q.z]), np.array([p.x, p.y, p.z])
