"""What one run of an estimator on a log produced, step by step."""

from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class TrackRecord:
    """The estimates of K objects at N updates.

    Attributes:
        method: "pbpf", "pbpf-v", "cvpf" or "dope".
        object_names: K names of tracked models.
        times: (N,) times of the updates since the log's start (in seconds).
        poses: (N, K, 7) estimated X_WO: qw qx qy qz, x y z (in meters).
        tracked: (N, K) whether the object had been detected by then; where
            it had not, ``poses`` holds the scene's nominal pose.
        detected: (N, K) whether a new detection was used at this update.
        covariances: (N, K, 6, 6) rotation vector first, then position, in
            the world; zeros for estimators without one.
        effective_sample_size: (N,); zeros for estimators without particles.
        particles: (N, M, K, 7) as ``poses``; M is 0 without particles.
        weights: (N, M) of the particles.
        particles_used: (N,) n, of the M particles; 0 without particles.
        update_ms: (N,) wall time of each update (in milliseconds).
        period: of the updates; each should take less than this (in seconds).
        seed: of the run.
        config: of the filter, by field; of other estimators the period only.
        detection_counts: (K, F) how many detections had which fate; see the
            filter's port. Of other estimators there are no rows.
        most_rejected: (K,) the most detections in a row that were outliers to
            all particles.
    """

    method: str
    object_names: tuple[str, ...]
    times: np.ndarray
    poses: np.ndarray
    tracked: np.ndarray
    detected: np.ndarray
    covariances: np.ndarray
    effective_sample_size: np.ndarray
    particles: np.ndarray
    weights: np.ndarray
    particles_used: np.ndarray
    update_ms: np.ndarray
    period: float
    seed: int = 0
    config: dict[str, object] = field(default_factory=dict)
    detection_counts: np.ndarray = field(
        default_factory=lambda: np.zeros((0, 0))
    )
    most_rejected: np.ndarray = field(default_factory=lambda: np.zeros(0))
