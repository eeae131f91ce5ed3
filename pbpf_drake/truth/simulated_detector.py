"""A simulated detector: what it gets wrong, and when it finds nothing.

How much of an object is visible decides whether it is detected. Where some of
it is hidden, good detections and outliers come mixed.
"""

from collections.abc import Sequence

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from pbpf_drake.config.detector_config import DetectorConfig
from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.log.log_records import DetectionRecord
from pbpf_drake.poses import quaternions
from pbpf_drake.truth.detection_outliers import (
    draw_directions,
    draw_outlier_error,
)


def clearness(visibility: float, config: DetectorConfig) -> float:
    """Returns how clear the view is: from 0, where nothing is detected, to 1.

    Args:
        visibility: the visible share, in [0, 1].
        config: its two thresholds.
    """
    low, high = config.hidden_visibility, config.clear_visibility
    return float(np.clip((visibility - low) / (high - low), 0.0, 1.0))


def detection_probability(visibility: float, config: DetectorConfig) -> float:
    """Returns the chance of a detection.

    It grows from 0 at the hidden visibility to 1 half-way to the clear one.

    Args:
        visibility: the visible share, in [0, 1].
        config: the two thresholds.
    """
    return min(1.0, 2 * clearness(visibility, config))


def draw_bias(config: DetectorConfig, rng: np.random.Generator) -> np.ndarray:
    """Draws how far off all detections of one object are in a run, (6,).

    Args:
        config: the ranges of distance and angle.
        rng: where the random numbers come from.

    Returns:
        A rotation vector (in radians), then a translation (in meters).
    """
    ranges = config.bias_rotation, config.bias_position
    sizes = np.array([[rng.uniform(r.min, r.max)] for r in ranges])
    return (sizes * draw_directions(rng)).ravel()


def draw_pose_error(stddev: PoseStddev, rng: np.random.Generator) -> np.ndarray:
    """Draws an error of a pose, (6,).

    Args:
        stddev: of the position along each axis, and of the rotation's angle.
        rng: where the random numbers come from.

    Returns:
        A rotation vector (in radians), then a translation (in meters).
    """
    axis = rng.standard_normal(3)
    axis /= np.linalg.norm(axis)
    rotation = stddev.rotation * rng.standard_normal() * axis
    return np.hstack([rotation, stddev.position * rng.standard_normal(3)])


def add_pose_error(X_CO: RigidTransform, error: np.ndarray) -> RigidTransform:
    """Returns X_CO turned about the object's origin, then shifted, in C.

    Args:
        X_CO: a pose.
        error: (6,) a rotation vector (in radians), then a translation (in
            meters), as from ``draw_pose_error``.
    """
    q = quaternions.from_rotation_vector(error[:3])
    R = RotationMatrix(Quaternion(wxyz=q)) @ X_CO.rotation()
    return RigidTransform(R, X_CO.translation() + error[3:])


class SimulatedDetector:
    """Says for each image what a detector would have found in it.

    The same random numbers are drawn for every image, whatever is detected.
    Hence a change of what is visible in one image changes no other detection.
    """

    def __init__(
        self,
        *,
        config: DetectorConfig,
        names: Sequence[str],
        X_WC: RigidTransform,
        rng: np.random.Generator,
    ) -> None:
        """Draws this run's constant errors.

        Args:
            config: how far off, how late and how often detections are.
            names: of the K objects.
            X_WC: pose of the camera's optical frame in the world.
            rng: where all random numbers come from.
        """
        self._config = config
        self._names = tuple(names)
        self._X_CW = X_WC.inverse()
        self._rng = rng
        self._biases = [draw_bias(config, rng) for _ in names]

    def Detect(
        self,
        *,
        time: float,
        poses: Sequence[RigidTransform],
        visibility: np.ndarray,
    ) -> list[DetectionRecord]:
        """Returns the detections in one image, up to one per object.

        Args:
            time: when the image is taken (in seconds).
            poses: K true poses X_WO.
            visibility: (K,) visible shares in [0, 1].
        """
        config, rng = self._config, self._rng
        detections = []
        for name, bias, X_WO, share in zip(
            self._names, self._biases, poses, visibility, strict=True
        ):
            noise = draw_pose_error(config.noise, rng)
            occlusion = 1 - clearness(share, config)
            outlier = draw_outlier_error(occlusion, config, rng)
            if rng.uniform() >= detection_probability(share, config):
                continue
            X_CO = self._X_CW @ X_WO
            for error in (bias, noise, outlier):
                X_CO = add_pose_error(X_CO, error)
            detections.append(
                DetectionRecord(
                    name=name,
                    time=time,
                    received=time + config.latency,
                    X_CO=X_CO,
                )
            )
        return detections
