"""Tells from the detections when a track is lost. Not in the paper.

Particles can be cut off from where the object is: after somebody poked it,
they may be on the wrong side of the hand, which they can't pass. Detections
then keep falling to the same side of all particles. One that is far off is
an outlier; several that agree with each other, but not with the particles,
mean that the track is lost.
"""

from dataclasses import dataclass

import numpy as np

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.filtering.filter_state import FilterState, StampedPose
from pbpf_drake.filtering.observation_model import OUTLIER, agrees
from pbpf_drake.filtering.particle_history import ParticleHistory
from pbpf_drake.filtering.update_step import UpdateStep

# The share of the latest disagreement in the running mean.
_GAIN = 0.25
# A single detection counts as this many standard deviations at most ...
_LARGEST = 3.0
# ... and one that may be an outlier counts less: two of them are not enough,
# three that agree are.
_LARGEST_OUTLIER = 2.0
# A track counts as lost where χ² with 3 degrees of freedom is above this. By
# chance it is in every ninth case. So low a limit finds what was poked just
# before it is hidden, and where the track is intact, drawing particles anew
# does little harm.
_LOST = 6.0
# So does one that so many detections in a row are outliers to, also if it is
# for their rotations.
_REJECTED = 8


@dataclass(frozen=True)
class TrackWatch:
    """What the detections of an update say of the tracks.

    Attributes:
        disagreement: (K, 3) the running means; see mean_disagreement.
        num_rejected: (K,) how many detections in a row were outliers to all
            particles.
        lost: (K,) which tracks are lost. Their other two are reset.
    """

    disagreement: np.ndarray
    num_rejected: np.ndarray
    lost: np.ndarray


def watch_tracks(
    state: FilterState,
    history: ParticleHistory,
    supports: np.ndarray,
    step: UpdateStep,
    config: ParticleFilterConfig,
) -> TrackWatch:
    """Compares detections with particles.

    The disagreement stays as it is where an object isn't tracked or wasn't
    detected. Nothing counts as lost unless ``recover_lost_tracks`` is set.

    Args:
        state: the state after the last update.
        history: the predicted particles, and where they were before.
        supports: (n, K, 3) the normals of what they stand on, or zeros.
        step: the update.
        config: the filter's.
    """
    stddev = config.detection_noise
    disagreement = state.disagreement.copy()
    num_rejected = count_rejected(state.num_rejected, history, step, stddev)
    lost = np.zeros(len(disagreement), dtype=bool)
    for k, seen in step.detections.items():
        if not step.active[k]:
            continue
        disagreement[k] = mean_disagreement(
            disagreement[k],
            history.end[:, k, 4:],
            np.array([_position_now(history, k, x) for x in seen]),
            stddev.position,
            _common_support(supports[:, k]),
        )
        is_gone = is_lost(disagreement[k]) or num_rejected[k] >= _REJECTED
        if config.recover_lost_tracks and is_gone:
            lost[k] = True
            disagreement[k] = num_rejected[k] = 0.0
    return TrackWatch(disagreement, num_rejected, lost)


def count_rejected(
    last: np.ndarray,
    history: ParticleHistory,
    step: UpdateStep,
    stddev: PoseStddev,
) -> np.ndarray:
    """Returns how many detections in a row were outliers to all, (K,).

    It is 0 after one that some particle agrees with, and of what isn't
    tracked.

    Args:
        last: (K,) what this function returned at the last update, or zeros.
        history: the predicted particles, and where they were before.
        step: the update.
        stddev: σ_DOPE.
    """
    count = np.where(step.active, last, 0.0)
    for k, seen in step.detections.items():
        for detection in seen if step.active[k] else ():
            poses = history.at(detection.time, k)
            is_fine = agrees(poses, detection.pose, stddev)
            count[k] = 0.0 if is_fine else count[k] + 1
    return count


def _position_now(
    history: ParticleHistory, k: int, detection: StampedPose
) -> np.ndarray:
    """Returns a detected position (3,) as far on as particles have moved.

    Only of a detection that is older than the update they have moved far.
    """
    position = detection.pose[4:]
    if detection.time >= history.times[-2]:
        return position
    moved = history.end[:, k, 4:] - history.at(detection.time, k)[:, 4:]
    return position + np.mean(moved, axis=0)


def mean_disagreement(
    last: np.ndarray,
    particles: np.ndarray,
    detections: np.ndarray,
    stddev: float,
    support: np.ndarray,
) -> np.ndarray:
    """Returns the running mean of the disagreement, (3,).

    It is the offset of the detections from the mean of the particles, in
    standard deviations, which come from both: with a gain of a, the running
    mean of an intact track is N(0, a / (2 - a)) along each axis.

    Args:
        last: (3,) what this function returned at the last update, or zeros.
        particles: (M, 3) predicted positions (in meters).
        detections: (n, 3) detected positions (in meters), n > 0.
        stddev: σ_DOPE of a position (in meters).
        support: (3,) the normal of what the particles stand on, or zeros.
            They can't follow along it: an offset there is a bias of the
            detector.
    """
    offset = np.mean(detections, axis=0) - np.mean(particles, axis=0)
    offset -= (support @ offset) * support
    spread = particles - np.mean(particles, axis=0)
    covariance = spread.T @ spread / len(particles)
    covariance += np.eye(3) * stddev**2 / len(detections)
    whitened = np.linalg.solve(np.linalg.cholesky(covariance), offset)
    length = float(np.linalg.norm(whitened))
    limit = _LARGEST if length < OUTLIER else _LARGEST_OUTLIER
    whitened *= min(1.0, limit / max(length, 1e-12))
    return (1 - _GAIN) * last + _GAIN * whitened


def is_lost(disagreement: np.ndarray) -> bool:
    """Returns whether a running mean, (3,), is more than chance."""
    return bool(disagreement @ disagreement * (2 - _GAIN) / _GAIN > _LOST)


def _common_support(supports: np.ndarray) -> np.ndarray:
    """Returns the unit normal (3,) that most particles stand on, or zeros."""
    mean = np.mean(supports, axis=0)
    length = np.linalg.norm(mean)
    return mean / length if length > 0.5 else np.zeros(3)
