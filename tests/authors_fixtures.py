"""Writes a log in the layout of the paper authors' recordings."""

from bag_fixtures import Entry
import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from pbpf_drake.log import Log
from pbpf_drake.pose_conversion import pose_array, rigid_transform
from pbpf_drake.ros2_messages import (
    JOINT_STATE,
    POSE_STAMPED,
    TF_MESSAGE,
    header_message,
    pose_message,
    to_nanoseconds,
)

# What the authors' motion capture calls objects.
TRUTH_IDS = {"cracker": "cheezit", "soup": "zisongsoup"}
# The robot's base in the world, and in the motion capture's frame.
X_WB = RigidTransform([0.0, 0.0, 0.02])
X_MB = RigidTransform(RollPitchYaw(0.02, -0.01, 2.1), [-0.7, 1.3, 0.85])


def authors_entries(log: Log, X_WC: RigidTransform) -> list[Entry]:
    """Returns a log's messages in the authors' layout, as received.

    The camera is in tf below the robot's base, and DOPE's poses are below the
    camera. Motion capture sees the objects and the robot's base.

    Args:
        log: what was recorded.
        X_WC: pose of the camera in the world.
    """

    def ns(time: float) -> int:
        return to_nanoseconds(start_time=log.start_time, time=time)

    entries: list[Entry] = []
    X_BC = X_WB.inverse() @ X_WC
    for i, time in enumerate(log.joints.times):
        stamp = ns(time)
        message = {
            "header": header_message(stamp=stamp, frame_id=""),
            "name": list(log.joints.names),
            "position": log.joints.positions[i].tolist(),
        }
        if log.joints.velocities is not None:
            message["velocity"] = log.joints.velocities[i].tolist()
        entries.append((stamp, "/joint_states", JOINT_STATE, message))
    for time in np.arange(0.0, log.duration + 0.05, 0.05):
        stamp = ns(time)
        tf = transform(stamp, "/panda_link0", "/RealSense", X_BC)
        entries.append((stamp, "/tf", TF_MESSAGE, {"transforms": [tf]}))
        base = "/mocap/rigid_bodies/pandaRobot/pose"
        entries.append((stamp, base, POSE_STAMPED, _pose(stamp, X_MB)))
    for d in log.detections:
        tf = transform(ns(d.time), "/RealSense", f"/{d.name}", d.X_CO)
        received = ns(d.received)
        entries.append((received, "/tf", TF_MESSAGE, {"transforms": [tf]}))
    for name, record in log.ground_truth.items():
        topic = f"/mocap/rigid_bodies/{TRUTH_IDS[name]}/pose"
        for i, time in enumerate(record.times):
            X_WO = rigid_transform(np.r_[record.q_WO[i], record.p_WO[i]])
            X_MO = X_MB @ X_WB.inverse() @ X_WO
            message = _pose(ns(time), X_MO)
            entries.append((ns(time), topic, POSE_STAMPED, message))
    return sorted(entries, key=lambda entry: entry[0])


def transform(stamp: int, parent: str, child: str, X: RigidTransform) -> dict:
    """Returns a geometry_msgs/TransformStamped; ``stamp`` in nanoseconds."""
    pose = pose_array(X)
    return {
        "header": header_message(stamp=stamp, frame_id=parent),
        "child_frame_id": child,
        "transform": {
            "translation": dict(zip("xyz", pose[4:], strict=True)),
            "rotation": dict(zip("wxyz", pose[:4], strict=True)),
        },
    }


def _pose(stamp: int, X: RigidTransform) -> dict:
    pose = pose_array(X)
    return {
        "header": header_message(stamp=stamp, frame_id="world"),
        "pose": pose_message(q=pose[:4], p=pose[4:]),
    }
