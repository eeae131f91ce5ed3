"""The importance factor of a particle, given a detection (Section 4.2)."""

import numpy as np

from pbpf_drake import quaternions
from pbpf_drake.particle_filter_config import PoseStddev


def detection_log_likelihood(
    poses: np.ndarray, detection: np.ndarray, stddev: PoseStddev
) -> np.ndarray:
    """Returns log N(x̄; DOPE(z), σ_DOPE²) up to a constant, (M,).

    Args:
        poses: (M, 7) particles x̄: qw qx qy qz, x y z (in meters).
        detection: (7,), the pose that the detector reports.
        stddev: σ_DOPE of the distance and of the angle between the two.
    """
    distance = np.linalg.norm(poses[:, 4:] - detection[4:], axis=-1)
    angle = quaternions.angle_between(poses[:, :4], detection[:4])
    return -0.5 * (
        np.square(distance / stddev.position)
        + np.square(angle / stddev.rotation)
    )
