"""Turns a recorded push with two fingers (CSV) into a log.

The columns are t [s]; obj_x, obj_y [m], obj_theta [rad]: the pose of the block
that a camera saw; detected: 1 where it did; pusher_x, pusher_y [m],
pusher_theta [rad]: the sensed point midway between the fingers and the
direction in which they push. The data are those of
robinzhoucmu/PlanarManipulationToolBox.

The detections are real, and so are the times without one. Between two pushes
nothing was recorded for some seconds, while the robot moved its fingers to
another side of the block. The log has the fingers lifted, moved and lowered
there.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.diagrams.recorded_pushes.push_csv import (
    MakeDetections,
    planar_poses,
    read_rows,
    stack_columns,
)
from pbpf_drake.log.log_records import JointRecord, Log

JOINT_NAMES = ("pusher_x", "pusher_y", "pusher_z", "pusher_theta")
_RECORDED_JOINTS = ("pusher_x", "pusher_y", "pusher_theta")
_OBJECT = ("obj_x", "obj_y", "obj_theta")
# Rows come about every 30 ms. A time without rows that is longer than this is a
# pause (in seconds).
_PAUSE = 1.0
# How high the fingers are lifted (in meters), and how fast (in seconds).
_LIFT = 0.05
_LIFT_TIME = 0.3
# An arbitrary date: the recordings have none.
_START_TIME = 1_495_540_800_000_000_000


def ReadTwoFingerPush(
    filename: str | Path,
    *,
    X_WC: RigidTransform,
    height: float,
    object_name: str = "block",
) -> Log:
    """Reads one recording.

    Its ground truth is the detections: there is no better one.

    Args:
        filename: the CSV file.
        X_WC: pose of the camera in which detections are expressed.
        height: of the block's centre above the table (in meters).
        object_name: the name of the tracked model.

    Raises:
        ValueError: the file lacks a column, rows, or a number in one.
    """
    rows = read_rows(filename, ["t", "detected", *_OBJECT, *_RECORDED_JOINTS])
    times = rows["t"] - rows["t"][0]
    seen = rows["detected"] > 0
    truth = planar_poses(
        times[seen], stack_columns(rows[seen], _OBJECT), height
    )
    return Log(
        joints=lift_in_pauses(times, stack_columns(rows, _RECORDED_JOINTS)),
        detections=MakeDetections(
            object_name=object_name,
            times=truth.times,
            poses=np.hstack([truth.q_WO, truth.p_WO]),
            X_WC=X_WC,
        ),
        ground_truth={object_name: truth},
        start_time=_START_TIME,
    )


def lift_in_pauses(times: np.ndarray, positions: np.ndarray) -> JointRecord:
    """Returns the motion of the fingers with what happens in its pauses.

    Args:
        times: (N,) strictly increasing (in seconds).
        positions: (N, 3) of x, y (in meters) and theta (in radians), which
            may jump by whole turns.

    Returns:
        The positions of ``JOINT_NAMES``. At the beginning of a pause the
        fingers are lifted from where they are, and at its end they are lowered
        to where they are then.
    """
    x, y, theta = positions.T
    q = np.column_stack([x, y, np.zeros(len(x)), np.unwrap(theta)])
    before = np.flatnonzero(np.diff(times) > _PAUSE)
    lifted = np.concatenate([q[before], q[before + 1]])
    lifted[:, 2] = _LIFT
    up, down = times[before] + _LIFT_TIME, times[before + 1] - _LIFT_TIME
    all_times = np.concatenate([times, up, down])
    order = np.argsort(all_times)
    return JointRecord(
        names=JOINT_NAMES,
        times=all_times[order],
        positions=np.concatenate([q, lifted])[order],
    )


def find_dropouts(times: np.ndarray, shortest: float) -> np.ndarray:
    """Returns when nothing was detected, (D, 2): from when to when.

    Args:
        times: (N,) of the detections, increasing (in seconds).
        shortest: a dropout is longer than this (in seconds).

    Returns:
        the times of the last detection before each and of the first after it.
    """
    before = np.flatnonzero(np.diff(times) > shortest)
    return np.column_stack([times[before], times[before + 1]])


def was_lifted(joints: JointRecord, start: float, end: float) -> bool:
    """Tells if the fingers were lifted at a time in an interval."""
    inside = (joints.times >= start) & (joints.times <= end)
    return bool(np.any(joints.positions[inside, JOINT_NAMES.index("pusher_z")]))


def cut_to_update(log: Log, time: float, period: float) -> Log:
    """Returns the log up to a time, with an update then but no detection.

    So the last estimate is what was known just before that detection. The
    beginning is cut by less than a period, so that an update falls on that
    time. The joints go on for half a period more.

    Args:
        log: the whole.
        time: when to be, within the log (in seconds).
        period: of the updates (in seconds).
    """
    start = time - period * np.floor(time / period)
    joints, end = log.joints, time + period / 2
    inside = (joints.times > start) & (joints.times < end)
    times = np.concatenate([[start], joints.times[inside], [end]])
    q = [np.interp(times, joints.times, x) for x in joints.positions.T]
    return replace(
        log,
        joints=replace(
            joints, times=times - start, positions=np.column_stack(q)
        ),
        detections=tuple(
            replace(d, time=d.time - start, received=d.received - start)
            for d in log.detections
            if d.time >= start and d.received < time
        ),
        ground_truth={},
    )
