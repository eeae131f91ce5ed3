"""A synthetic run of an estimator, for tests that need some record."""

import numpy as np

from pbpf_drake.log import PoseRecord
from pbpf_drake.quaternions import from_rotation_vector
from pbpf_drake.track_record import TrackRecord

OFFSET = np.array([0.03, 0.0, -0.04])  # 5 cm long.
TURN = np.array([0.0, 0.12, 0.05])  # 0.13 rad.


def make_truth(*, start: float = 0.0, end: float = 10.0) -> PoseRecord:
    """Returns an object that moves by 0.1 m/s along x and doesn't turn."""
    times = np.array([start, end])
    q = np.tile([1.0, 0.0, 0.0, 0.0], (2, 1))
    return PoseRecord(times, q, np.outer(times, [0.1, 0.0, 0.0]))


def make_record(
    *,
    method: str = "pbpf",
    names: tuple[str, ...] = ("box",),
    num_steps: int = 10,
    num_particles: int = 4,
    growth: float = 0.0,
) -> TrackRecord:
    """Returns estimates that are off by OFFSET and TURN.

    Args:
        method: of the record.
        names: of the objects.
        num_steps: N; updates are at 1 s, 2 s, …
        num_particles: M.
        growth: by what the errors' size grows with each step, relatively.
    """
    count = len(names)
    times = np.arange(1, num_steps + 1, dtype=float)
    scale = 1 + growth * np.arange(num_steps)[:, None, None]
    p = times[:, None, None] * [0.1, 0.0, 0.0] + scale * OFFSET
    q = from_rotation_vector(scale * TURN)
    poses = np.broadcast_to(
        np.concatenate([q, p], axis=-1), (num_steps, count, 7)
    )
    spread = np.diag([0.01, 0.02, 0.02, 0.002, 0.003, 0.006]) ** 2
    covariances = np.tile(spread, (num_steps, count, 1, 1))
    return TrackRecord(
        method=method,
        object_names=names,
        times=times,
        poses=np.array(poses),
        tracked=np.ones((num_steps, count), dtype=bool),
        detected=np.ones((num_steps, count), dtype=bool),
        covariances=covariances * (num_particles > 0),
        effective_sample_size=np.full(num_steps, 0.5 * num_particles),
        particles=np.zeros((num_steps, num_particles, count, 7)),
        weights=np.full((num_steps, num_particles), 1 / max(num_particles, 1)),
        particles_used=np.full(num_steps, float(num_particles)),
        update_ms=np.arange(1.0, num_steps + 1),
        period=0.0085,
        seed=7,
        config={"num_particles": num_particles},
    )
