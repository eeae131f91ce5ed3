"""Where a log holds what the filter needs: topics, frames and presets.

The types of the messages are read from the log itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
import math

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform

from pbpf_drake.config.config_checks import fixed_pose, require

# Where either a topic or a tf frame can be named, a frame's name starts so.
TF_PREFIX = "tf:"
_AXES = "xyz"


@dataclass(kw_only=True)
class LogTopics:
    """Where a log holds what the filter needs.

    A topic or frame with ``{name}`` in it is one per object; see
    ``TrackedObject`` for the names that are put there.
    """

    # A key of PRESETS, which has the values of fields that are left out.
    preset: str = "pbpf"
    # sensor_msgs/JointState.
    joint_states: str = "/joint_states"
    # Other topics of the same type with more joints of the robot, such as a
    # gripper's. Each topic may have its own rate.
    more_joint_states: list[str] = field(default_factory=list)
    # Names of joints in the log, by names of joints in the robot's model,
    # where they differ.
    joint_names: dict[str, str] = field(default_factory=dict)
    # Positions of joints that nobody measures, by names of joints in the
    # robot's model (in radians or meters). What the log says of them isn't
    # used.
    fixed_joints: dict[str, float] = field(default_factory=dict)
    # For a robot whose joints are coordinates of tf frames in the world: frame
    # and axis, as in "link_tip.x", by names of joints in the robot's model.
    # Then joint states aren't read.
    tf_joints: dict[str, str] = field(default_factory=dict)
    # A topic of Detection3DArray, PoseStamped, PoseWithCovarianceStamped or
    # TransformStamped, or "tf:" and the name of a tf frame.
    detections: str = "/dope/detected_objects"
    # A topic of PoseStamped, PoseWithCovarianceStamped or TransformStamped, or
    # "tf:" and the name of a tf frame.
    ground_truth: str = "/ground_truth/{name}"
    # A topic of the same types with the pose of the reference frame, as the
    # system sees it that the ground truth is from. Empty if tf connects the
    # two.
    ground_truth_base: str = ""
    # A topic of sensor_msgs/Image or CompressedImage. The same name with
    # "/compressed" behind it is looked for as well. Only pictures need it.
    images: str = "/camera/color/image_raw"
    # The frame of the log whose pose in the world is X_WR. Empty if no frames
    # of the log are to be used: then detections are in the frame of the scene's
    # camera, and ground truth is in the world.
    reference_frame: str = ""
    X_WR: Transform = field(default_factory=Transform)
    # The optical frame of the camera in tf. If it is empty or not in tf, the
    # camera is where the scene says.
    camera_frame: str = ""
    # tf2_msgs/TFMessage.
    tf: str = "/tf"
    tf_static: str = "/tf_static"

    def joint_topics(self) -> tuple[str, ...]:
        """Returns all topics of joint states, each once."""
        topics = (self.joint_states, *self.more_joint_states)
        return tuple(dict.fromkeys(topics))

    def ReferencePose(self) -> RigidTransform:
        """Returns X_WR."""
        return self.X_WR.GetDeterministicValue()

    def ValidateOrThrow(self) -> None:
        """Raises ValueError, naming the field, if a value can't be used."""
        known = self.preset in PRESETS
        require(known, "preset", self.preset, f"one of {list(PRESETS)}")
        for name in ("joint_states", "detections", "ground_truth", "images"):
            _check_source(name, getattr(self, name))
        self._CheckJoints()
        require(not is_frame(self.images), "images", self.images, "a topic")
        if not self.reference_frame:
            self._CheckNothingIsInTf()
        fixed_pose(self.X_WR, "X_WR")
        for joint, coordinate in self.tf_joints.items():
            frame, _, axis = coordinate.rpartition(".")
            require(
                bool(frame) and len(axis) == 1 and axis in _AXES,
                f"tf_joints.{joint}",
                coordinate,
                "a frame and an axis, as in 'link_tip.x'",
            )

    def _CheckJoints(self) -> None:
        for topic in self.joint_topics():
            require(
                bool(topic) and not is_frame(topic),
                "joint_states"
                if topic == self.joint_states
                else "more_joint_states",
                topic,
                "a topic; joints that are in tf are named by tf_joints",
            )
        for joint, value in self.fixed_joints.items():
            require(
                math.isfinite(value),
                f"fixed_joints.{joint}",
                value,
                "a finite position",
            )

    def _CheckNothingIsInTf(self) -> None:
        in_tf = {
            "detections": is_frame(self.detections),
            "ground_truth": is_frame(self.ground_truth),
            "tf_joints": bool(self.tf_joints),
        }
        for name, is_in_tf in in_tf.items():
            if is_in_tf:
                raise ValueError(
                    f"{name} is {getattr(self, name)!r} and reference_frame is "
                    "empty; expected the frame in which tf is to be resolved"
                )


def _check_source(field_name: str, value: str) -> None:
    require(
        bool(value) and value != TF_PREFIX and not value.endswith("/"),
        field_name,
        value,
        "a whole name, in which {name} stands for the object's",
    )


def is_frame(source: str) -> bool:
    """Tells if a source is a tf frame and not a topic."""
    return source.startswith(TF_PREFIX)


def frame_name(name: str) -> str:
    """Returns a frame's name without "tf:" and without the / of ROS 1."""
    return name.removeprefix(TF_PREFIX).lstrip("/")


def for_object(source: str, name: str) -> str:
    """Returns a topic or frame with the object's name put in."""
    return source.replace("{name}", name)


def _isaac_ros_dope() -> LogTopics:
    """NVIDIA's isaac_ros_dope beside a driver that publishes tf."""
    return LogTopics(preset="isaac_ros_dope", detections="/detections")


def _authors() -> LogTopics:
    """The recordings of the paper's authors.

    Detections and the camera are in tf. Motion capture sees the objects and the
    robot's base, which is 20 mm above the table's top.
    """
    return LogTopics(
        preset="authors",
        detections="tf:{name}",
        ground_truth="/mocap/rigid_bodies/{name}/pose",
        ground_truth_base="/mocap/rigid_bodies/pandaRobot/pose",
        reference_frame="panda_link0",
        X_WR=Transform(translation=np.array([0.0, 0.0, 0.02])),
        camera_frame="RealSense",
    )


# By the name that a scene file gives.
PRESETS: dict[str, Callable[[], LogTopics]] = {
    "pbpf": LogTopics,
    "isaac_ros_dope": _isaac_ros_dope,
    "authors": _authors,
}
