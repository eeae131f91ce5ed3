"""What the robot did within one period, as a polyline in joint space."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ControlPath:
    """Joint positions that are passed through in straight lines.

    This is u_t of the paper: what the robot did since the last update.

    Attributes:
        times: (S,) ascending (in seconds).
        positions: (S, n) joint positions (in radians or meters).
    """

    times: np.ndarray
    positions: np.ndarray


def add_hermite_midpoints(
    path: ControlPath, velocities: np.ndarray
) -> ControlPath:
    """Returns the path with a point amid each segment, from the velocities.

    The cubic that has the given positions and velocities at both ends passes
    through (q₀ + q₁)/2 + (v₀ - v₁) Δt/8 halfway.

    Args:
        path: S points.
        velocities: (S, n) at the path's points (in rad/s or m/s).
    """
    q, t = path.positions, path.times
    dt = np.diff(t)
    middle = (q[:-1] + q[1:]) / 2
    middle += (velocities[:-1] - velocities[1:]) * dt[:, None] / 8
    times = np.empty(2 * len(t) - 1)
    times[::2], times[1::2] = t, t[:-1] + dt / 2
    positions = np.empty((len(times), q.shape[1]))
    positions[::2], positions[1::2] = q, middle
    return ControlPath(times, positions)


def simplify_path(path: ControlPath, tolerance: float) -> ControlPath:
    """Returns the path with as few points as the tolerance allows.

    Ends are kept; of the rest, points are added where the simplified path is
    furthest from the whole one, until no joint is off by more than the
    tolerance at any of its points (Ramer-Douglas-Peucker, over time).

    Args:
        path: of any number of points.
        tolerance: largest error of any joint (in radians or meters).
    """
    t, q = path.times, path.positions
    keep = [0, len(t) - 1]
    while len(t) > 2:
        segment = np.searchsorted(t[keep[1:-1]], t, side="right")
        a, b = np.array(keep)[segment], np.array(keep)[segment + 1]
        u = (t - t[a]) / (t[b] - t[a])
        error = np.abs(q[a] + u[:, None] * (q[b] - q[a]) - q)
        error = error.max(axis=1, initial=0.0)  # Of no joints, too.
        worst = int(np.argmax(error))
        if error[worst] <= tolerance or worst in keep:
            return ControlPath(t[keep], q[keep])
        keep = sorted([*keep, worst])
    return path
