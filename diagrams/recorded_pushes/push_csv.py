"""Reads recorded planar pushes from CSV files.

The first line of a file has the names of its columns; then there is a row per
time.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.log.log_records import DetectionRecord, PoseRecord
from pbpf_drake.poses import quaternions
from pbpf_drake.poses.pose_conversion import rigid_transform


def read_rows(filename: str | Path, columns: Sequence[str]) -> np.ndarray:
    """Returns the rows of a file, (N,), with N ≥ 1 and columns by name.

    Args:
        filename: the CSV file.
        columns: names of columns that the file must have, in any order and
            with a number in every row. There may be others.

    Raises:
        ValueError: the file lacks a column, rows, or a number in one, or its
            rows differ in length.
    """
    try:
        rows = np.atleast_1d(np.genfromtxt(filename, delimiter=",", names=True))
    except (ValueError, IndexError) as error:
        raise ValueError(
            f"{filename} is no table with names in its first line and rows of "
            f"the same length: {error}"
        ) from error
    missing = [c for c in columns if c not in (rows.dtype.names or ())]
    if missing:
        raise ValueError(f"{filename} has no columns {missing}")
    if not rows.size or not all(np.all(np.isfinite(rows[c])) for c in columns):
        raise ValueError(f"{filename} has no rows, or one without a number")
    return rows


def stack_columns(rows: np.ndarray, columns: Sequence[str]) -> np.ndarray:
    """Returns some columns of N rows as one array, (N, number of columns)."""
    return np.column_stack([rows[c] for c in columns])


def planar_poses(
    times: np.ndarray, poses: np.ndarray, height: float
) -> PoseRecord:
    """Returns the motion of an object that stays upright on a table.

    Args:
        times: (N,) in seconds.
        poses: (N, 3) of x, y (in meters) and theta about z (in radians).
        height: of the object's origin (in meters).
    """
    turn = np.zeros_like(poses)
    turn[:, 2] = poses[:, 2]
    z = np.full(len(poses), height)
    return PoseRecord(
        times=times,
        q_WO=quaternions.from_rotation_vector(turn),
        p_WO=np.column_stack([poses[:, :2], z]),
    )


def MakeDetections(
    *,
    object_name: str,
    times: np.ndarray,
    poses: Iterable[np.ndarray],
    X_WC: RigidTransform,
) -> tuple[DetectionRecord, ...]:
    """Returns a detection per time, which is known without any delay.

    Args:
        object_name: the name of the tracked model.
        times: (N,) in seconds.
        poses: N poses X_WO (7,).
        X_WC: pose of the camera.
    """
    X_CW = X_WC.inverse()
    return tuple(
        DetectionRecord(
            name=object_name,
            time=t,
            received=t,
            X_CO=X_CW @ rigid_transform(pose),
        )
        for t, pose in zip(times, poses, strict=True)
    )
