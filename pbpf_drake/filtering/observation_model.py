"""The importance factor of a particle, given a detection (Section 4.2)."""

import numpy as np

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.poses import quaternions

# So many standard deviations off, an outlier is as likely as a detection.
_OUTLIER = 5.0


def poses_at(start: np.ndarray, end: np.ndarray, fraction: float) -> np.ndarray:
    """Returns poses (M, 7) between those at two times.

    Args:
        start: (M, 7) at the earlier time: qw qx qy qz, x y z (in meters).
        end: (M, 7) at the later time.
        fraction: 0 at the earlier time, 1 at the later; clipped to that.
    """
    u = min(max(fraction, 0.0), 1.0)
    same = np.sum(start[:, :4] * end[:, :4], axis=-1, keepdims=True) >= 0
    q = (1 - u) * start[:, :4] + u * np.where(same, end[:, :4], -end[:, :4])
    p = (1 - u) * start[:, 4:] + u * end[:, 4:]
    return np.concatenate([quaternions.normalize(q), p], axis=-1)


def detection_log_likelihood(
    poses: np.ndarray, detection: np.ndarray, stddev: PoseStddev
) -> np.ndarray:
    """Returns log N(x̄; DOPE(z), σ_DOPE²) up to a constant, (M,).

    A position, or a rotation, that is further off than outliers are supposed
    to be says nothing more: a detection that no particle agrees with leaves
    the weights alone. That is not in the paper.

    Args:
        poses: (M, 7) particles x̄: qw qx qy qz, x y z (in meters).
        detection: (7,), the pose that the detector reports.
        stddev: σ_DOPE of the distance and of the angle between the two.
    """
    distance = np.linalg.norm(poses[:, 4:] - detection[4:], axis=-1)
    angle = quaternions.angle_between(poses[:, :4], detection[:4])
    return _log_gaussian(distance / stddev.position) + _log_gaussian(
        angle / stddev.rotation
    )


def _log_gaussian(deviations: np.ndarray) -> np.ndarray:
    """Returns the log of a Gaussian's share and of that of outliers."""
    return np.logaddexp(-0.5 * deviations**2, -0.5 * _OUTLIER**2)
