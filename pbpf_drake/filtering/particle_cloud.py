"""The particles of an update, from when they are complete."""

from dataclasses import dataclass

import numpy as np

from pbpf_drake.filtering.particle_history import ParticleHistory


@dataclass(frozen=True)
class ParticleCloud:
    """The n particles that an update weighs.

    Attributes:
        history: x̄, and where they were before.
        drawn: (n, K, 7) where they were before they were pushed out: qw qx qy
            qz, x y z (in meters), X_WO.
        velocities: (n, K, 6) angular (rad/s), then translational (m/s).
        failed: (n,) which could not be predicted and must not survive.
    """

    history: ParticleHistory
    drawn: np.ndarray
    velocities: np.ndarray
    failed: np.ndarray
