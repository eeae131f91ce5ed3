"""Tells from the detections when a track is lost. Not in the paper.

Particles can be cut off from where the object is: after somebody poked it,
they may be on the wrong side of the hand, which they can't pass. Detections
then keep falling to the same side of all particles. One that is far off is
an outlier; several that agree with each other, but not with the particles,
mean that the track is lost.
"""

import numpy as np

# The share of the latest disagreement in the running mean.
_GAIN = 0.25
# A single detection counts as this many standard deviations at most ...
_LARGEST = 3.0
# ... and one that is so far off that it may be an outlier counts less: two of
# them are not enough, three that agree are.
_OUTLIER = 5.0
_OUTLIER_COUNTS = 2.0
# χ² with 3 degrees of freedom exceeds it in every ninth case by chance, too.
# Then the particles that are drawn anew do little harm, while what was poked
# just before it is hidden has to be found at once.
_LOST = 6.0


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
    limit = _LARGEST if length < _OUTLIER else _OUTLIER_COUNTS
    whitened *= min(1.0, limit / max(length, 1e-12))
    return (1 - _GAIN) * last + _GAIN * whitened


def is_lost(disagreement: np.ndarray) -> bool:
    """Returns whether a running mean, (3,), is more than chance."""
    return bool(disagreement @ disagreement * (2 - _GAIN) / _GAIN > _LOST)
