"""The detections between two updates: which are kept, and which are new.

Of each object there are rows of a stamp (in seconds) and a pose X_WO (qw qx qy
qz, x y z in meters), the latest last. A row that isn't filled yet has the
stamp -inf.
"""

from collections.abc import Sequence

import numpy as np

from pbpf_drake.dope_measurement import DopeMeasurement
from pbpf_drake.filtering.filter_state import StampedPose
from pbpf_drake.poses.pose_conversion import pose_array

# A stamp may be so much later than now (in seconds), by rounding.
_SAME_TIME = 1e-6
# A detection that is further off (in meters) is out of range.
_FARTHEST = 1e3


def make_empty_rows(num_objects: int, count: int) -> np.ndarray:
    """Returns so many rows per object that aren't filled yet, (K, S, 8)."""
    return np.full((num_objects, count, 8), -np.inf)


def add_measurement(
    rows: np.ndarray,
    measurement: DopeMeasurement,
    *,
    object_names: Sequence[str],
    now: float,
    max_age: float,
) -> np.ndarray:
    """Returns the rows with the detections of a measurement that can be used.

    Those can that are later than the last row, not of the future, not too old,
    finite, and not out of range.

    Args:
        rows: (K, S, 8).
        measurement: the latest detection of each object.
        object_names: of the K objects.
        now: (in seconds).
        max_age: of what is used (in seconds).
    """
    rows = rows.copy()
    for k, name in enumerate(object_names):
        detection = measurement.detections.get(name)
        if detection is None or not detection.time > rows[k, -1, 0]:
            continue
        row = np.append(detection.time, pose_array(detection.X_WO))
        is_recent = -_SAME_TIME <= now - detection.time <= max_age
        if is_recent and np.all(np.abs(row[1:]) <= _FARTHEST):
            rows[k] = np.vstack([rows[k, 1:], row])
    return rows


def unused_detections(
    rows: np.ndarray, last_used: np.ndarray
) -> dict[int, list[StampedPose]]:
    """Returns by object index the detections that no update has used yet.

    Args:
        rows: (K, S, 8).
        last_used: (K,) stamps of the last detections that were used.
    """
    unused = {}
    for k, of_object in enumerate(rows):
        new = of_object[of_object[:, 0] > last_used[k]]
        if len(new):
            unused[k] = [StampedPose(row[0], row[1:]) for row in new]
    return unused
