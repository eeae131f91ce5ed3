"""Turns a recorded planar push (CSV) into a log, with simulated detections.

The columns are t [s], slider_x, slider_y [m], slider_theta [rad]: the motion
capture's pose of the block's centre; pusher_x, pusher_y [m]: the sensed
position of the probe; new_pose: 1 where the block's pose is a new sample. The
data are those of mcubelab/cpush.

The detector is simulated: it sees the motion capture's pose with noise at 15
Hz, and nothing in a blackout, when the camera is said to be blocked.
"""

from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.diagrams.recorded_pushes.push_csv import (
    MakeDetections,
    planar_poses,
    read_rows,
    stack_columns,
)
from pbpf_drake.filtering.pose_noise import perturb_poses
from pbpf_drake.log.log_records import (
    DetectionRecord,
    JointRecord,
    Log,
    PoseRecord,
)
from pbpf_drake.log.pose_interpolation import interpolate_poses

_JOINT_NAMES = ("pusher_x", "pusher_y")
_OBJECT = ("slider_x", "slider_y", "slider_theta")
_DETECTION_RATE = 15.0
# Noise about each axis: of the position (in meters) and of the rotation (in
# radians).
_POSITION_STDDEV = 0.02
_ROTATION_STDDEV = 0.09
# An arbitrary date: the recordings have none.
_START_TIME = 1_477_180_800_000_000_000


def ReadPlanarPush(
    filename: str | Path,
    *,
    seed: int,
    X_WC: RigidTransform,
    height: float,
    object_name: str = "block",
    blackout: tuple[float, float] = (0.4, 0.8),
) -> Log:
    """Reads one push.

    Args:
        filename: the CSV file.
        seed: of the noise of the detections.
        X_WC: pose of the camera in which detections are expressed.
        height: of the block's centre above the table (in meters).
        object_name: the name of the tracked model.
        blackout: between which shares of the duration nothing is detected.

    Raises:
        ValueError: the file lacks a column, rows, or a number in one.
    """
    rows = read_rows(filename, ["t", *_OBJECT, *_JOINT_NAMES, "new_pose"])
    times = rows["t"] - rows["t"][0]
    # Rows in which the motion capture has a new sample, and the first row.
    new = rows["new_pose"] > 0
    new[0] = True
    truth = planar_poses(times[new], stack_columns(rows[new], _OBJECT), height)
    return Log(
        joints=JointRecord(
            names=_JOINT_NAMES,
            times=times,
            positions=stack_columns(rows, _JOINT_NAMES),
        ),
        detections=SimulateDetections(
            truth,
            duration=times[-1],
            seed=seed,
            X_WC=X_WC,
            object_name=object_name,
            blackout=(blackout[0] * times[-1], blackout[1] * times[-1]),
        ),
        ground_truth={object_name: truth},
        start_time=_START_TIME,
    )


def SimulateDetections(
    truth: PoseRecord,
    *,
    duration: float,
    seed: int,
    X_WC: RigidTransform,
    object_name: str,
    blackout: tuple[float, float],
) -> tuple[DetectionRecord, ...]:
    """Returns the truth with noise at 15 Hz, but nothing in a blackout.

    Args:
        truth: the motion of the object.
        duration: of the log (in seconds).
        seed: of the noise.
        X_WC: pose of the camera.
        object_name: the name of the tracked model.
        blackout: when nothing is detected, its ends included (in seconds).
    """
    stamps = np.arange(0.0, min(duration, truth.times[-1]), 1 / _DETECTION_RATE)
    q, p = interpolate_poses(truth, stamps)
    rng = np.random.default_rng(seed)
    noisy = perturb_poses(
        np.concatenate([q, p], axis=1),
        _POSITION_STDDEV * rng.standard_normal(p.shape),
        _ROTATION_STDDEV * rng.standard_normal(p.shape),
    )
    hidden = (stamps >= blackout[0]) & (stamps <= blackout[1])
    return MakeDetections(
        object_name=object_name,
        times=stamps[~hidden],
        poses=noisy[~hidden],
        X_WC=X_WC,
    )
