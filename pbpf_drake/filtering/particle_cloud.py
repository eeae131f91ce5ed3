"""The particles of an update, from when they are complete."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ParticleCloud:
    """The n particles that an update weighs.

    Attributes:
        start: (n, K, 7) where they were at the beginning of the step: qw qx
            qy qz, x y z (in meters), X_WO.
        drawn: (n, K, 7) where they were before they were pushed out.
        end: (n, K, 7) x̄, where they are at the end of the step.
        velocities: (n, K, 6) angular (rad/s), then translational (m/s).
        failed: (n,) which could not be predicted and must not survive.
    """

    start: np.ndarray
    drawn: np.ndarray
    end: np.ndarray
    velocities: np.ndarray
    failed: np.ndarray
