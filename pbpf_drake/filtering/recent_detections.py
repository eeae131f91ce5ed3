"""The detections between two updates: which are kept, which are left out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pbpf_drake.dope_measurement import DopeMeasurement
from pbpf_drake.filtering.filter_state import StampedPose
from pbpf_drake.poses.pose_conversion import pose_array

# What becomes of a detection: the columns of detection_counts.
DETECTION_FATES = (
    "used",
    "too old",
    "of the future",
    "older than the one before",
    "not finite, or too far away",
)
_USED, _TOO_OLD, _FUTURE, _OUT_OF_ORDER, _UNUSABLE = range(5)
# Bounds of positions, (2, 3): 1 km to all sides of the world's origin.
ANYWHERE = np.outer([-1e3, 1e3], np.ones(3))
# A stamp may be so much later than now (in seconds), by rounding.
_SAME_TIME = 1e-6


@dataclass(frozen=True)
class RecentDetections:
    """What is known of the detections on the port.

    Attributes:
        detection_rows: (K, S, 8) of each object the last S that can be used,
            the latest last: a stamp (in seconds) and a pose X_WO (qw qx qy qz,
            x y z in meters). The stamp is -inf where there is none yet.
        detection_stamps: (K,) the stamp of the last one that there was, used
            or not (in seconds); -inf where there was none.
        detection_counts: (K, 5) how many had which of the DETECTION_FATES.
    """

    detection_rows: np.ndarray
    detection_stamps: np.ndarray
    detection_counts: np.ndarray

    def unused(self, last_used: np.ndarray) -> dict[int, list[StampedPose]]:
        """Returns by object index what no update has used yet, latest last.

        Args:
            last_used: (K,) stamps of the last detections that were used.
        """
        unused = {}
        for k, rows in enumerate(self.detection_rows):
            new = rows[rows[:, 0] > last_used[k]]
            if len(new):
                unused[k] = [StampedPose(row[0], row[1:]) for row in new]
        return unused


def make_no_detections(num_objects: int, num_rows: int) -> RecentDetections:
    """Returns what is known before there is any, with S rows per object."""
    return RecentDetections(
        detection_rows=np.full((num_objects, num_rows, 8), -np.inf),
        detection_stamps=np.full(num_objects, -np.inf),
        detection_counts=np.zeros((num_objects, len(DETECTION_FATES))),
    )


def add_measurement(
    recent: RecentDetections,
    measurement: DopeMeasurement,
    *,
    object_names: Sequence[str],
    now: float,
    max_age: float,
    bounds: np.ndarray,
) -> RecentDetections:
    """Returns what is known with what a measurement has that is new.

    Args:
        recent: what was known before.
        measurement: the latest detection of each object.
        object_names: of the K objects.
        now: (in seconds).
        max_age: of what is used (in seconds).
        bounds: (2, 3) the lowest and the highest position in the world that
            an object may be detected at (in meters).
    """
    rows, stamps, counts = (array.copy() for array in vars(recent).values())
    for k, name in enumerate(object_names):
        detection = measurement.detections.get(name)
        if detection is None:
            continue
        is_new = not _is_same(detection.time, stamps[k])
        if not is_new and not detection.time > rows[k, -1, 0]:
            continue
        row = np.append(detection.time, pose_array(detection.X_WO))
        fate = _find_fate(row, rows[k, -1, 0], now, max_age, bounds)
        if is_new:
            stamps[k] = detection.time
            counts[k, fate] += 1
        elif fate == _USED:  # Its time has come.
            counts[k, _FUTURE] -= 1
            counts[k, _USED] += 1
        if fate == _USED:
            rows[k] = np.vstack([rows[k, 1:], row])
    return RecentDetections(rows, stamps, counts)


def _find_fate(
    row: np.ndarray,
    last_used: float,
    now: float,
    max_age: float,
    bounds: np.ndarray,
) -> int:
    """Returns the index of one of DETECTION_FATES."""
    low, high = bounds
    is_near = np.all((low <= row[5:]) & (row[5:] <= high))
    if not is_near or not np.all(np.isfinite(row)):
        return _UNUSABLE
    age = now - row[0]
    if age < -_SAME_TIME:
        return _FUTURE
    if age > max_age:
        return _TOO_OLD
    return _USED if row[0] > last_used else _OUT_OF_ORDER


def _is_same(time: float, other: float) -> bool:
    """Returns whether two stamps are equal, also if they aren't numbers."""
    return time == other or bool(np.isnan(time) and np.isnan(other))
