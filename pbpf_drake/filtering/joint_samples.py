"""The joints between two updates: samples of them, and the path they make.

Samples are rows of time (in seconds), n positions (in radians or meters) and
n velocities (per second), the latest last. A row that isn't filled yet has the
time -inf. A joint that has never had a finite position has NaN.
"""

import numpy as np

from pbpf_drake.motion.control_path import ControlPath, add_hermite_midpoints

# Samples closer than this (in seconds) are one.
_SAME_TIME = 1e-6


def make_empty_rows(count: int, num_joints: int) -> np.ndarray:
    """Returns so many rows that aren't filled yet, (S, 1 + 2 n)."""
    samples = np.zeros((count, 1 + 2 * num_joints))
    samples[:, 0] = -np.inf
    samples[:, 1 : 1 + num_joints] = np.nan
    return samples


def make_row(
    time: float,
    positions: np.ndarray,
    velocities: np.ndarray | None,
    last: np.ndarray,
) -> np.ndarray:
    """Returns a row, (1 + 2 n,).

    Args:
        time: now (in seconds).
        positions: (n,) as measured (in radians or meters).
        velocities: (n,) as measured (per second); None counts as zeros.
        last: (1 + 2 n,) the last row, which stands in for what isn't finite.
    """
    if velocities is None:
        velocities = np.zeros(len(positions))
    row = np.concatenate([[time], positions, velocities])
    return np.where(np.isfinite(row), row, last)


def append_row(samples: np.ndarray, sample: np.ndarray) -> np.ndarray:
    """Returns (S, 1 + 2 n) with a row as the last, and without the first.

    One of the same time as the last row takes its place.
    """
    is_same = sample[0] - samples[-1, 0] <= _SAME_TIME
    return np.vstack([samples[:-1] if is_same else samples[1:], sample])


def path_since(samples: np.ndarray, time: float, *, bend: bool) -> ControlPath:
    """Returns u_t, the joints' path from a time to the last sample.

    Args:
        samples: (S, 1 + 2 n).
        time: of the last update (in seconds); the path starts at the last
            sample until then, or at the first that there is.
        bend: whether the velocities bend the path between two samples.
    """
    samples = samples[np.isfinite(samples[:, 0])]
    known = np.all(np.isfinite(samples), axis=1)
    samples = samples[known] if known[-1:].any() else samples
    start = np.searchsorted(samples[:, 0], time + _SAME_TIME) - 1
    since = samples[max(start, 0) :]
    since = since[np.append(np.diff(since[:, 0]) > _SAME_TIME, True)]
    times, positions, velocities = np.split(
        since, [1, 1 + (since.shape[1] - 1) // 2], axis=1
    )
    path = ControlPath(times[:, 0], positions)
    return add_hermite_midpoints(path, velocities) if bend else path
