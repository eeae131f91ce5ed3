"""Where a log holds what the filter needs: topics, frames and presets.

What type a topic's messages have is read from the log itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform

# What a name of a tf frame starts with, where a topic could be as well.
TF_PREFIX = "tf:"
_AXES = "xyz"


@dataclass(kw_only=True)
class LogTopics:
    """Where a log holds what the filter needs.

    A topic or frame with ``{name}`` in it is one per object; see
    ``TrackedObject`` for the names that are put there.
    """

    # A key of PRESETS: what the fields are that are left out.
    preset: str = "pbpf"
    # sensor_msgs/JointState.
    joint_states: str = "/joint_states"
    # Names of joints in the log, by names of joints in the robot's model,
    # where they differ.
    joint_names: dict[str, str] = field(default_factory=dict)
    # For a robot whose joints are coordinates of a tf frame in the world, by
    # names of joints in its model: "link_tip.x". Joint states aren't read then.
    tf_joints: dict[str, str] = field(default_factory=dict)
    # A topic of Detection3DArray, PoseStamped, PoseWithCovarianceStamped or
    # TransformStamped, or "tf:" and the name of a tf frame.
    detections: str = "/dope/detected_objects"
    # A topic of PoseStamped, PoseWithCovarianceStamped or TransformStamped, or
    # "tf:" and the name of a tf frame.
    ground_truth: str = "/ground_truth/{name}"
    # A topic of the same types with the pose of the reference frame as the
    # ground truth's own system sees it. Empty: tf connects the two.
    ground_truth_base: str = ""
    # A topic of sensor_msgs/Image or CompressedImage. With "/compressed" behind
    # it, it is looked for as well. Nothing but pictures needs it.
    images: str = "/camera/color/image_raw"
    # The log's frame whose pose in the world is X_WR. Empty: no frames of the
    # log are looked at. Then detections are in the scene's camera and ground
    # truth is in the world.
    reference_frame: str = ""
    X_WR: Transform = field(default_factory=Transform)
    # The optical frame of the camera in tf. Empty, or not in tf: the camera is
    # where the scene says.
    camera_frame: str = ""
    # tf2_msgs/TFMessage.
    tf: str = "/tf"
    tf_static: str = "/tf_static"

    def ReferencePose(self) -> RigidTransform:
        """Returns X_WR."""
        return self.X_WR.GetDeterministicValue()

    def ValidateOrThrow(self) -> None:
        """Raises ValueError if a field can't be; the message says why."""
        if self.preset not in PRESETS:
            raise ValueError(
                f"preset is {self.preset!r}; expected one of {list(PRESETS)}"
            )
        for name in ("joint_states", "detections", "ground_truth", "images"):
            _check_source(name, getattr(self, name))
        if is_frame(self.joint_states):
            raise ValueError(
                f"joint_states is {self.joint_states!r}; expected a topic;"
                " joints that are in tf are named by tf_joints"
            )
        if is_frame(self.images):
            raise ValueError(f"images is {self.images!r}; expected a topic")
        if not self.reference_frame:
            for name in ("detections", "ground_truth", "tf_joints"):
                if is_frame(getattr(self, name)) or name == "tf_joints":
                    self._CheckNeedsNoReference(name)
        self._CheckReferencePose()
        for joint, coordinate in self.tf_joints.items():
            frame, _, axis = coordinate.rpartition(".")
            if not frame or axis not in _AXES or len(axis) != 1:
                raise ValueError(
                    f"tf_joints.{joint} is {coordinate!r}; expected a frame "
                    "and an axis, as in 'link_tip.x'"
                )

    def _CheckNeedsNoReference(self, name: str) -> None:
        if getattr(self, name):
            raise ValueError(
                f"{name} is {getattr(self, name)!r} and reference_frame is "
                "empty; expected the frame in which tf is to be resolved"
            )

    def _CheckReferencePose(self) -> None:
        if self.X_WR.base_frame or not self.X_WR.IsDeterministic():
            raise ValueError("X_WR is not one pose in the world")
        if not np.all(np.isfinite(self.ReferencePose().GetAsMatrix4())):
            raise ValueError("X_WR is not finite")


def _check_source(field_name: str, value: str) -> None:
    if not value or value == TF_PREFIX or value.endswith("/"):
        raise ValueError(
            f"{field_name} is {value!r}; expected a whole name, in which "
            "{name} stands for the object's"
        )


def is_frame(source: str | dict) -> bool:
    """Tells if a source is a tf frame and not a topic."""
    return isinstance(source, str) and source.startswith(TF_PREFIX)


def frame_name(name: str) -> str:
    """Returns the frame of a source, or a frame's name without ROS 1's /."""
    return name.removeprefix(TF_PREFIX).lstrip("/")


def for_object(source: str, name: str) -> str:
    """Returns a topic or frame with the object's name put in."""
    return source.replace("{name}", name)


def _isaac_ros_dope() -> LogTopics:
    """NVIDIA's isaac_ros_dope beside a driver that publishes tf."""
    return LogTopics(preset="isaac_ros_dope", detections="/detections")


def _authors() -> LogTopics:
    """The recordings of the paper's authors.

    DOPE and the camera are in tf; motion capture sees the robot's base as
    well, which is 20 mm above the table's top.
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
