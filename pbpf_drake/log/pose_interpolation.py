"""Poses between the samples of a recorded motion."""

import numpy as np

from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.poses.quaternions import (
    conjugate,
    from_rotation_vector,
    multiply,
    normalize,
    to_rotation_vector,
)


def find_segments(
    sample_times: np.ndarray, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns where times lie between samples: x = (1 - u) x[i] + u x[j].

    Args:
        sample_times: (S,) strictly increasing (in seconds).
        times: (...) any times (in seconds); those before the first or after
            the last sample are moved there.

    Returns:
        i, j, u, each (...): indices of the samples before and after, equal
        where there is only one sample, and the fraction u in [0, 1].
    """
    last = len(sample_times) - 1
    i = np.searchsorted(sample_times, times, side="right") - 1
    i = np.clip(i, 0, max(last - 1, 0))
    j = np.minimum(i + 1, last)
    length = np.where(i == j, 1.0, sample_times[j] - sample_times[i])
    u = np.clip((times - sample_times[i]) / length, 0.0, 1.0)
    return i, j, u


def interpolate_poses(
    record: PoseRecord, times: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the poses of an object at given times.

    Positions are interpolated linearly, rotations at constant angular
    velocity along the shorter way (slerp). Before the first and after the
    last sample the object rests.

    Args:
        record: the recorded motion.
        times: (N,) since the log's start (in seconds).

    Returns:
        q_WO (N, 4) as w, x, y, z, and p_WO (N, 3) in meters.
    """
    i, j, u = find_segments(record.times, np.asarray(times, dtype=float))
    u = u[..., np.newaxis]
    p = (1 - u) * record.p_WO[i] + u * record.p_WO[j]
    turn = to_rotation_vector(
        multiply(conjugate(record.q_WO[i]), record.q_WO[j])
    )
    q = multiply(record.q_WO[i], from_rotation_vector(u * turn))
    return normalize(q), p
