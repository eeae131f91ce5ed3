"""What an update hands to the next one."""

import numpy as np

from pbpf_drake.filtering.filter_state import FilterState
from pbpf_drake.filtering.particle_cloud import ParticleCloud
from pbpf_drake.filtering.track_loss import TrackWatch
from pbpf_drake.filtering.update_step import UpdateStep, index_mask


def make_next_state(
    state: FilterState,
    *,
    step: UpdateStep,
    cloud: ParticleCloud,
    weights: np.ndarray,
    mean: np.ndarray,
    watch: TrackWatch,
) -> FilterState:
    """Returns the state after an update that had n of M particles.

    The other M - n have a place in it all the same: they repeat the first n,
    with a weight of 0.

    Args:
        state: the state before it.
        step: the update.
        cloud: its particles.
        weights: (n,) of them, with the sum 1.
        mean: (K, 7) x̃_t.
        watch: what its detections say of the tracks.
    """
    num_spare = len(state.weights) - len(weights)
    last = state.estimates[0]
    times = state.detection_times.copy()
    for k, seen in step.detections.items():
        times[k] = seen[-1].time
    return FilterState(
        poses=_repeat(cloud.history.end, num_spare),
        velocities=_repeat(cloud.velocities, num_spare),
        weights=np.concatenate([weights, np.zeros(num_spare)]),
        num_used=np.array([float(len(weights))]),
        estimates=np.stack([np.where(step.known[:, None], mean, last), last]),
        num_estimates=np.minimum(state.num_estimates + step.known, 2),
        detection_times=times,
        detected=index_mask(step.detections, len(times)) * 1.0,
        disagreement=watch.disagreement,
        num_rejected=watch.num_rejected,
        history=_repeat(cloud.history.poses[1:-1], num_spare, axis=1),
        history_times=cloud.history.times[1:-1],
        step=state.step + 1,
    )


def _repeat(particles: np.ndarray, num_spare: int, axis: int = 0) -> np.ndarray:
    """Returns n particles, along an axis, and so many of them once more."""
    count = particles.shape[axis]
    return particles.take(np.arange(count + num_spare) % count, axis)
