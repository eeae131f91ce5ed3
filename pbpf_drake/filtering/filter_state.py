"""What the particle filter hands from one update to the next."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class StampedPose:
    """A detection of one object.

    Attributes:
        time: stamp of the image (in seconds).
        pose: (7,) X_WO: qw qx qy qz, x y z (in meters).
    """

    time: float
    pose: np.ndarray


@dataclass(frozen=True)
class FilterState:
    """All that one update hands to the next.

    Attributes:
        poses: (M, K, 7) particles: qw qx qy qz, x y z (in meters), X_WO.
        velocities: (M, K, 6) angular (rad/s), then translational (m/s).
        weights: (M,) importance factors, normalized.
        num_used: (1,) n, how many particles the last update had: the first n.
            The others repeat them, with a weight of 0.
        estimates: (2, K, 7) the mean of the last update, and of the one
            before it.
        num_estimates: (K,) how many of the two there are; an object without
            any isn't tracked yet.
        detection_times: (K,) stamps of the last detections that were used.
        detected: (K,) 1 where the last update used a detection, else 0.
        disagreement: (K, 3) of the detections with the particles; see
            track_loss.
        num_rejected: (K,) how many detections in a row were outliers to all
            particles.
        history: (H, M, K, 7) where the particles were at the ends of the
            updates before the last one, the latest last.
        history_times: (H,) when that was (in seconds); -inf where there was
            no update yet.
        step: (1,) count of updates.
    """

    poses: np.ndarray
    velocities: np.ndarray
    weights: np.ndarray
    num_used: np.ndarray
    estimates: np.ndarray
    num_estimates: np.ndarray
    detection_times: np.ndarray
    detected: np.ndarray
    disagreement: np.ndarray
    num_rejected: np.ndarray
    history: np.ndarray
    history_times: np.ndarray
    step: np.ndarray


def MakeInitialState(
    num_particles: int, nominal_poses: np.ndarray, history_length: int = 0
) -> FilterState:
    """Returns the state before the first detection.

    Args:
        num_particles: M.
        nominal_poses: (K, 7), which stand for estimates until there are any.
        history_length: H.
    """
    num_objects = len(nominal_poses)
    return FilterState(
        poses=np.tile(nominal_poses, (num_particles, 1, 1)),
        velocities=np.zeros((num_particles, num_objects, 6)),
        weights=np.full(num_particles, 1.0 / num_particles),
        num_used=np.array([float(num_particles)]),
        estimates=np.tile(nominal_poses, (2, 1, 1)),
        num_estimates=np.zeros(num_objects),
        detection_times=np.full(num_objects, -np.inf),
        detected=np.zeros(num_objects),
        disagreement=np.zeros((num_objects, 3)),
        num_rejected=np.zeros(num_objects),
        history=np.tile(nominal_poses, (history_length, num_particles, 1, 1)),
        history_times=np.full(history_length, -np.inf),
        step=np.zeros(1),
    )
