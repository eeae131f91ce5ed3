"""Writes what a tracker saw and estimated as an MCAP file.

It holds ROS 2 messages, which Foxglove, Rerun and `ros2 bag` can read.
"""

from pathlib import Path
from typing import Any

from mcap.records import Schema
from mcap_ros2.writer import Writer
import numpy as np

from pbpf_drake.bags.image_messages import jpeg_fields
from pbpf_drake.bags.ros2_messages import (
    COMPRESSED_IMAGE,
    JOINT_STATE,
    POSE_ARRAY,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    header_message,
    message_definition,
    pose_message,
    to_nanoseconds,
)
from pbpf_drake.dope_measurement import Detection
from pbpf_drake.log.mcap_log_writer import CAMERA_FRAME, CHUNK_SIZE, WORLD_FRAME
from pbpf_drake.poses.pose_conversion import pose_array

# In ROS, a covariance has the position first, then the rotation.
_ROS_ORDER = [3, 4, 5, 0, 1, 2]


class TrackMcap:
    """An MCAP file that is being written; a context manager.

    The log time of a message is that of the update that it belongs to.
    """

    def __init__(self, *, filename: str | Path, start_time: int):
        """Opens the file.

        Args:
            filename: the file to write; its folder must exist.
            start_time: what times are relative to, since the epoch (in
                nanoseconds).
        """
        self._start_time = start_time
        self._writer = Writer(str(filename), chunk_size=CHUNK_SIZE)
        self._schemas: dict[str, Schema] = {}

    def __enter__(self) -> "TrackMcap":
        """Returns the file."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Completes the file."""
        self.Close()

    def Close(self) -> None:
        """Completes the file."""
        self._writer.finish()

    def WriteJoints(
        self, time: float, names: tuple[str, ...], q: np.ndarray, v: np.ndarray
    ) -> None:
        """Writes the robot's n joints to /joint_states.

        Args:
            time: of the update (in seconds).
            names: of the joints in the model.
            q: (n,) positions (in radians or meters).
            v: (n,) velocities, per second.
        """
        message = {
            "name": list(names),
            "position": q.tolist(),
            "velocity": v.tolist(),
        }
        self._Write("/joint_states", JOINT_STATE, message, time, frame="")

    def WriteDetection(
        self, time: float, name: str, detection: Detection
    ) -> None:
        """Writes a detection to /pbpf/detection/<object>.

        Args:
            time: of the update that used it (in seconds).
            name: of the object.
            detection: the message's header has the time of the detection.
        """
        X = pose_array(detection.X_WO)
        self._Write(
            f"/pbpf/detection/{name}",
            POSE_STAMPED,
            {"pose": pose_message(q=X[:4], p=X[4:])},
            time,
            stamped=detection.time,
        )

    def WriteEstimate(
        self,
        time: float,
        name: str,
        pose: np.ndarray,
        covariance: np.ndarray,
    ) -> None:
        """Writes an estimate to /pbpf/estimate/<object>.

        Args:
            time: of the update (in seconds).
            name: of the object.
            pose: (7,) X_WO: qw qx qy qz, x y z (in meters).
            covariance: (6, 6) rotation vector first, then position.
        """
        ordered = covariance[np.ix_(_ROS_ORDER, _ROS_ORDER)]
        message = {
            "pose": {
                "pose": pose_message(q=pose[:4], p=pose[4:]),
                "covariance": ordered.ravel().tolist(),
            }
        }
        self._Write(
            f"/pbpf/estimate/{name}",
            POSE_WITH_COVARIANCE_STAMPED,
            message,
            time,
        )

    def WriteParticles(
        self, time: float, name: str, particles: np.ndarray
    ) -> None:
        """Writes particles to /pbpf/particles/<object>.

        Args:
            time: of the update (in seconds).
            name: of the object.
            particles: (M, 7), each as ``pose`` in WriteEstimate.
        """
        poses = [pose_message(q=x[:4], p=x[4:]) for x in particles]
        self._Write(
            f"/pbpf/particles/{name}", POSE_ARRAY, {"poses": poses}, time
        )

    def WriteImage(self, time: float, image: np.ndarray) -> None:
        """Writes an image to /pbpf/overlay/compressed, as JPEG.

        Args:
            time: of the update (in seconds).
            image: (height, width, 3): blue, green, red.
        """
        self._Write(
            "/pbpf/overlay/compressed",
            COMPRESSED_IMAGE,
            jpeg_fields(image),
            time,
            frame=CAMERA_FRAME,
        )

    def _Write(
        self,
        topic: str,
        kind: str,
        message: dict[str, Any],
        time: float,
        *,
        frame: str = WORLD_FRAME,
        stamped: float | None = None,
    ) -> None:
        def nanoseconds(seconds: float) -> int:
            return to_nanoseconds(start_time=self._start_time, time=seconds)

        stamp = nanoseconds(time if stamped is None else stamped)
        header = header_message(stamp=stamp, frame_id=frame)
        self._writer.write_message(
            topic=topic,
            schema=self._Schema(kind),
            message={"header": header, **message},
            log_time=nanoseconds(time),
        )

    def _Schema(self, kind: str) -> Schema:
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_msgdef(
                kind, message_definition(kind)
            )
        return self._schemas[kind]
