"""Turns a recorded planar push (CSV) into a log, with simulated detections.

The columns are t [s], slider_x, slider_y [m], slider_theta [rad]: the motion
capture's pose of the block's centre; pusher_x, pusher_y [m]: the sensed
position of the probe; new_pose: 1 where the block's pose is a new sample. The
data are those of mcubelab/cpush.

The detector is simulated: motion capture plus noise at 15 Hz, and nothing
while the camera is said to be blocked.
"""

from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake import quaternions
from pbpf_drake.log import DetectionRecord, JointRecord, Log, PoseRecord
from pbpf_drake.pose_conversion import rigid_transform
from pbpf_drake.pose_interpolation import interpolate_poses
from pbpf_drake.pose_noise import perturb_poses

_JOINT_NAMES = ("pusher_x", "pusher_y")
_DETECTION_RATE = 15.0
# Of each axis of the position (in meters) and of the rotation (in radians).
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
        X_WC: pose of the camera in which they are expressed.
        height: of the block's centre above the table (in meters).
        object_name: the name of the tracked model.
        blackout: between which shares of the duration nothing is detected.

    Raises:
        ValueError: the file lacks a column, rows, or a number in one.
    """
    rows = np.genfromtxt(filename, delimiter=",", names=True)
    columns = ["t", "slider_x", "slider_y", "slider_theta", *_JOINT_NAMES]
    columns.append("new_pose")
    names = rows.dtype.names or ()
    missing = [c for c in columns if c not in names]
    if missing:
        raise ValueError(f"{filename} has no columns {missing}")
    rows = np.atleast_1d(rows)
    if not rows.size or not all(np.all(np.isfinite(rows[c])) for c in columns):
        raise ValueError(f"{filename} has no rows, or one without a number")
    times = rows["t"] - rows["t"][0]
    truth = _Truth(times, rows, height)
    return Log(
        joints=JointRecord(
            names=_JOINT_NAMES,
            times=times,
            positions=np.column_stack([rows[n] for n in _JOINT_NAMES]),
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


def _Truth(times: np.ndarray, rows: np.ndarray, height: float) -> PoseRecord:
    """The new samples of the motion capture; the first counts as one."""
    new = rows["new_pose"] > 0
    new[0] = True
    turn = np.zeros((np.count_nonzero(new), 3))
    turn[:, 2] = rows["slider_theta"][new]
    return PoseRecord(
        times=times[new],
        q_WO=quaternions.from_rotation_vector(turn),
        p_WO=np.column_stack(
            [
                rows["slider_x"][new],
                rows["slider_y"][new],
                np.full(len(turn), height),
            ]
        ),
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
    X_CW = X_WC.inverse()
    hidden = (stamps >= blackout[0]) & (stamps <= blackout[1])
    return tuple(
        DetectionRecord(
            name=object_name,
            time=t,
            received=t,
            X_CO=X_CW @ rigid_transform(pose),
        )
        for t, pose in zip(stamps[~hidden], noisy[~hidden], strict=True)
    )
