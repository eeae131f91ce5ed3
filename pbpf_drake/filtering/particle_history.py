"""Where the particles of an update were, as far back as a detection may be."""

from dataclasses import dataclass

import numpy as np

from pbpf_drake.poses import quaternions


@dataclass(frozen=True)
class ParticleHistory:
    """The poses that each surviving particle has gone through.

    A detection is of the past: its image has to be taken, looked at, and sent.
    It says something about where a particle was then.

    Attributes:
        times: (S,) ascending (in seconds), S > 1: the ends of earlier updates,
            the beginning of this one, and its end. The first may be -inf: there
            was no update yet.
        poses: (S, n, K, 7) at these times: qw qx qy qz, x y z (in meters).
    """

    times: np.ndarray
    poses: np.ndarray

    @property
    def end(self) -> np.ndarray:
        """The poses (n, K, 7) at the end of the update."""
        return self.poses[-1]

    def at(self, time: float, k: int) -> np.ndarray:
        """Returns where object k of each particle was at a time, (n, 7).

        Before the first time that there is, that is where it was then.

        Args:
            time: (in seconds).
            k: which object.
        """
        first = int(np.searchsorted(self.times, -np.inf, side="right"))
        i = int(np.searchsorted(self.times, time, side="right")) - 1
        i = min(max(i, first), len(self.times) - 2)
        duration = max(self.times[i + 1] - self.times[i], 1e-9)
        return poses_between(
            self.poses[i, :, k],
            self.poses[i + 1, :, k],
            (time - self.times[i]) / duration,
        )

    def at_last_images(self, times: dict[int, float]) -> np.ndarray:
        """Returns where each object was when it was last seen, (n, K, 7).

        Args:
            times: by object index, when that was (in seconds); others are
                where they are at the end.
        """
        imaged = self.end.copy()
        for k, time in times.items():
            imaged[:, k] = self.at(time, k)
        return imaged


def poses_between(
    start: np.ndarray, end: np.ndarray, fraction: float
) -> np.ndarray:
    """Returns poses (n, 7) between those at two times.

    Args:
        start: (n, 7) at the earlier time: qw qx qy qz, x y z (in meters).
        end: (n, 7) at the later time.
        fraction: 0 at the earlier time, 1 at the later; clipped to that.
    """
    u = min(max(fraction, 0.0), 1.0)
    same = np.sum(start[:, :4] * end[:, :4], axis=-1, keepdims=True) >= 0
    q = (1 - u) * start[:, :4] + u * np.where(same, end[:, :4], -end[:, :4])
    p = (1 - u) * start[:, 4:] + u * end[:, 4:]
    return np.concatenate([quaternions.normalize(q), p], axis=-1)
