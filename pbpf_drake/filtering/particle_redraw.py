"""Draws particles from detections, where a track begins or is lost.

In the paper a track begins with particles that are spread around the first
detection (Section 6). Here they are also chosen by all detections that there
are. That lost tracks are recovered is not in the paper.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.filtering.filter_state import StampedPose
from pbpf_drake.filtering.observation_model import detection_log_likelihood
from pbpf_drake.filtering.pose_noise import sample_around
from pbpf_drake.filtering.resampling import normalize_log_weights
from pbpf_drake.filtering.update_step import UpdateStep
from pbpf_drake.random_streams import Stream

# New particles are chosen from this many times as many candidates: of 70 that
# are spread over 0.16 m and 0.43 rad, about one would be where the object is.
_CANDIDATES = 100


@dataclass(frozen=True)
class RedrawnParticles:
    """Particles of which some were drawn from detections.

    Attributes:
        poses: (n, K, 7) all of them.
        is_new: (n, K) which were drawn, and don't depend on the prediction.
    """

    poses: np.ndarray
    is_new: np.ndarray


def redraw_particles(
    predicted: np.ndarray,
    lost: np.ndarray,
    step: UpdateStep,
    config: ParticleFilterConfig,
) -> RedrawnParticles:
    """Draws all particles of new tracks, and half of those of lost ones.

    Which half of a lost track is right, the detections decide when the
    particles are weighed.

    Args:
        predicted: (n, K, 7) x̄, kept where nothing is drawn.
        lost: (K,) which tracks are lost.
        step: the update.
        config: the filter's.
    """
    poses = predicted.copy()
    is_new = np.zeros(poses.shape[:2], dtype=bool)
    for k, seen in step.detections.items():
        if not step.active[k]:
            is_new[:, k] = True
        elif lost[k]:
            is_new[::2, k] = True
        if count := int(np.count_nonzero(is_new[:, k])):
            # Each object has its own share of this stream.
            stream = step.MakeGenerator(Stream.INITIAL_PARTICLES)
            rng = stream.spawn(k + 1)[k]
            poses[is_new[:, k], k] = draw_from_detections(
                seen, count, config, rng
            )
    return RedrawnParticles(poses, is_new)


def draw_from_detections(
    seen: Sequence[StampedPose],
    count: int,
    config: ParticleFilterConfig,
    rng: np.random.Generator,
) -> np.ndarray:
    """Returns particles of one object, (count, 7).

    Candidates are spread around the last detection with the initial noise.
    Of these, particles are drawn by the likelihood of all detections.

    Args:
        seen: the object's detections, the latest last.
        count: how many particles to draw.
        config: the filter's.
        rng: where the numbers come from.
    """
    candidates = sample_around(
        seen[-1].pose, _CANDIDATES * count, config.initial_noise, rng
    )
    log_weights = [
        detection_log_likelihood(
            candidates, detection.pose, config.detection_noise
        )
        for detection in seen
    ]
    weights = normalize_log_weights(np.sum(log_weights, axis=0))
    return rng.choice(candidates, count, p=weights)
