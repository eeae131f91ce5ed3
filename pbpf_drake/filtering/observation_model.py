"""The importance factor of a particle, given detections (Section 4.2)."""

from collections.abc import Sequence

import numpy as np

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.filtering.filter_state import StampedPose
from pbpf_drake.filtering.particle_cloud import ParticleCloud
from pbpf_drake.filtering.update_step import UpdateStep
from pbpf_drake.poses import quaternions

# A detection that is so many standard deviations off is taken for an outlier.
OUTLIER = 5.0


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
    distance, angle = _deviations(poses, detection, stddev)
    return _log_gaussian(distance) + _log_gaussian(angle)


def weigh_by_detections(
    cloud: ParticleCloud, step: UpdateStep, stddev: PoseStddev
) -> np.ndarray:
    """Returns log w, log p(z_t | x̄) up to a constant, (n,).

    Each detection is compared with where the particles were at its stamp. It
    is -inf for particles that failed.

    Args:
        cloud: the particles.
        step: the update, with the detections.
        stddev: σ_DOPE.
    """
    log_weights = np.where(cloud.failed, -np.inf, 0.0)
    for k, seen in step.detections.items():
        poses = [cloud.history.at(detection.time, k) for detection in seen]
        log_weights += _observation_log_likelihood(poses, seen, stddev)
        if not step.active[k]:
            # These detections have chosen the particles of the new track, and
            # must not count twice.
            drawn = [cloud.drawn[:, k]] * len(seen)
            log_weights -= _observation_log_likelihood(drawn, seen, stddev)
    return log_weights


def agrees(
    poses: np.ndarray, detection: np.ndarray, stddev: PoseStddev
) -> bool:
    """Returns whether a detection isn't an outlier to all particles.

    Args:
        poses: (n, 7) particles x̄ when the image was taken.
        detection: (7,), the pose that the detector reports.
        stddev: σ_DOPE.
    """
    distance, angle = _deviations(poses, detection, stddev)
    return bool(np.any((distance <= OUTLIER) & (angle <= OUTLIER)))


def _observation_log_likelihood(
    poses: Sequence[np.ndarray],
    seen: Sequence[StampedPose],
    stddev: PoseStddev,
) -> np.ndarray:
    """Returns the sum over detections, (n,), each with its poses, (n, 7)."""
    log_likelihood = np.zeros(len(poses[0]))
    for x, detection in zip(poses, seen, strict=True):
        log_likelihood += detection_log_likelihood(x, detection.pose, stddev)
    return log_likelihood


def _deviations(
    poses: np.ndarray, detection: np.ndarray, stddev: PoseStddev
) -> tuple[np.ndarray, np.ndarray]:
    """Returns distance and angle in standard deviations, (n,) each."""
    distance = np.linalg.norm(poses[:, 4:] - detection[4:], axis=-1)
    angle = quaternions.angle_between(poses[:, :4], detection[:4])
    return distance / stddev.position, angle / stddev.rotation


def _log_gaussian(deviations: np.ndarray) -> np.ndarray:
    """Returns the log of a Gaussian with a floor, so that outliers don't count.

    Beyond OUTLIER standard deviations it hardly falls any more.
    """
    return np.logaddexp(-0.5 * deviations**2, -0.5 * OUTLIER**2)
