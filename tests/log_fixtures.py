"""A small synthetic log and its scene, for tests that need some log."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from pbpf_drake.log import DetectionRecord, JointRecord, Log, PoseRecord
from pbpf_drake.quaternions import from_rotation_vector
from pbpf_drake.scene import Scene, TrackedObject

START_TIME = 1_700_000_000_123_456_789
JOINT_NAMES = ("slide_x", "slide_y", "wrist")


def make_small_scene() -> Scene:
    """Returns a scene that tracks "box" and has the default topics."""
    return Scene(robot="arm", tracked={"box": TrackedObject()})


def make_small_log(*, num_samples: int = 50, velocities: bool = True) -> Log:
    """Returns three joints at 100 Hz, a box with truth, detections at 10 Hz.

    Every number is arbitrary but smooth and fixed; times are whole
    nanoseconds. Detections arrive 30 ms after their stamp, and are of the
    true pose as seen by a camera at the world's origin.

    Args:
        num_samples: of joint states; two thirds as many of the true pose.
        velocities: whether joint states have velocities.
    """
    times = np.arange(num_samples) * 10_000_000 / 1e9
    phase = times[:, None] + np.array([0.1, 0.2, 0.3])
    joints = JointRecord(
        names=JOINT_NAMES,
        times=times,
        positions=np.sin(phase),
        velocities=np.cos(phase) if velocities else None,
    )
    truth_times = np.arange(num_samples * 2 // 3) * 15_000_000 / 1e9
    turn = truth_times[:, None] * np.array([0.3, -0.2, 0.9])
    truth = PoseRecord(
        times=truth_times,
        q_WO=from_rotation_vector(turn),
        p_WO=np.array([0.5, 0.1, 0.9]) + 0.05 * np.sin(phase[: len(turn)]),
    )
    detections = tuple(
        DetectionRecord(
            name="box",
            time=i * 100_000_000 / 1e9,
            received=(i * 100_000_000 + 30_000_000) / 1e9,
            X_CO=RigidTransform(
                RollPitchYaw(0.1 * i, -0.2, 0.3), [0.5, 0.01 * i, 0.9]
            ),
        )
        for i in range(num_samples // 10)
    )
    return Log(
        joints=joints,
        detections=detections,
        ground_truth={"box": truth},
        start_time=START_TIME,
    )
