"""What a log of a manipulation holds, whatever file it came from.

Times are seconds since the log's first joint state.
"""

from dataclasses import dataclass, field

import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.log.input_usage import InputUsage


@dataclass(frozen=True)
class JointRecord:
    """The measured joint motion of the robot.

    Attributes:
        names: n joint names, in the order of the columns.
        times: (N,) strictly increasing (in seconds).
        positions: (N, n) in radians or meters, all finite.
        velocities: (N, n) in rad/s or m/s, or None where the log has none.
    """

    names: tuple[str, ...]
    times: np.ndarray
    positions: np.ndarray
    velocities: np.ndarray | None = None


@dataclass(frozen=True)
class DetectionRecord:
    """One detection of one object.

    Attributes:
        name: the tracked model's name.
        time: stamp of the image (in seconds).
        received: when it became known, not before ``time`` (in seconds).
        X_CO: pose of the object in the camera's optical frame.
    """

    name: str
    time: float
    received: float
    X_CO: RigidTransform


@dataclass(frozen=True)
class PoseRecord:
    """The ground truth of one object.

    Attributes:
        times: (N,) strictly increasing (in seconds).
        q_WO: (N, 4) unit quaternions w, x, y, z.
        p_WO: (N, 3) positions in the world (in meters).
    """

    times: np.ndarray
    q_WO: np.ndarray
    p_WO: np.ndarray


@dataclass(frozen=True)
class Log:
    """One recorded manipulation.

    Attributes:
        joints: the robot's motion.
        detections: sorted by ``received``.
        ground_truth: by name of the tracked model; empty where unknown.
        start_time: time of the first joint state since the epoch (in
            nanoseconds), which times in this log are relative to.
        warnings: one sentence for everything that was left out, and why.
        X_WC: pose of the camera's optical frame in the world; None where it
            is that of the scene. Detections are in this camera.
        usage: how much of the input was used, for each topic and object.
    """

    joints: JointRecord
    detections: tuple[DetectionRecord, ...]
    ground_truth: dict[str, PoseRecord] = field(default_factory=dict)
    start_time: int = 0
    warnings: tuple[str, ...] = ()
    X_WC: RigidTransform | None = None
    usage: tuple[InputUsage, ...] = ()

    @property
    def duration(self) -> float:
        """Time of the last joint state (in seconds)."""
        return float(self.joints.times[-1])
