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


def weigh_by_detections(
    cloud: ParticleCloud, step: UpdateStep, stddev: PoseStddev
) -> np.ndarray:
    """Returns log w, log p(z_t | x̄) up to a constant, (n,).

    It is -inf for particles that failed.

    Args:
        cloud: the particles.
        step: the update, with the detections.
        stddev: σ_DOPE.
    """
    log_weights = np.where(cloud.failed, -np.inf, 0.0)
    for k, seen in step.detections.items():
        log_weights += observation_log_likelihood(
            cloud.start[:, k], cloud.end[:, k], seen, step, stddev
        )
        if not step.active[k]:
            # These detections have chosen the particles of the new track, and
            # must not count twice.
            drawn = cloud.drawn[:, k]
            log_weights -= observation_log_likelihood(
                drawn, drawn, seen, step, stddev
            )
    return log_weights


def observation_log_likelihood(
    start: np.ndarray,
    end: np.ndarray,
    seen: Sequence[StampedPose],
    step: UpdateStep,
    stddev: PoseStddev,
) -> np.ndarray:
    """Returns log p(z_t | x̄) of one object's detections, (n,).

    Each detection is compared with where the particles were at its stamp.

    Args:
        start: (n, 7) the particles at the beginning of the step.
        end: (n, 7) the particles at its end.
        seen: the detections.
        step: whose path says when it began and ended.
        stddev: σ_DOPE.
    """
    log_likelihood = np.zeros(len(end))
    for detection in seen:
        log_likelihood += detection_log_likelihood(
            poses_at(start, end, step.fraction(detection.time)),
            detection.pose,
            stddev,
        )
    return log_likelihood


def poses_at_last_images(
    start: np.ndarray, end: np.ndarray, step: UpdateStep
) -> np.ndarray:
    """Returns the particles when each object was last seen, (n, K, 7).

    Objects that weren't detected in this step are where they are at its end.

    Args:
        start: (n, K, 7) the particles at the beginning of the step.
        end: (n, K, 7) the particles at its end.
        step: the update.
    """
    imaged = end.copy()
    for k, seen in step.detections.items():
        fraction = step.fraction(seen[-1].time)
        imaged[:, k] = poses_at(start[:, k], end[:, k], fraction)
    return imaged


def _log_gaussian(deviations: np.ndarray) -> np.ndarray:
    """Returns the log of a Gaussian with a floor, so that outliers don't count.

    Beyond OUTLIER standard deviations it hardly falls any more.
    """
    return np.logaddexp(-0.5 * deviations**2, -0.5 * OUTLIER**2)
