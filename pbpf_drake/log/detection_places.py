"""Finds detections that can't be where they are said to be.

Units, fields and frames get mixed up; the numbers are finite all the same.
"""

import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.config.camera_config import CameraConfig

# Nearer to the camera than this, nothing is detected (in meters).
_MIN_DISTANCE = 0.12
# An object may be seen in part: its centre is outside the image by up to this
# share of the image's size.
_MARGIN = 0.2
# What is further from everything than this is nowhere (in meters).
_MAX_DISTANCE = 1.0
# Positions that are misplaced may be in another unit: that would be their size
# in meters, and they would be this near to something (in meters).
_FACTORS, _NEAR = (0.01, 0.001, 0.1, 10.0, 100.0, 1000.0), 0.1
# A larger share of misplaced detections than this is worth a warning.
_MAX_SHARE = 0.1


def place_warnings(
    p_CO: np.ndarray,
    *,
    camera: CameraConfig,
    X_WC: RigidTransform,
    boxes: np.ndarray,
) -> list[str]:
    """Returns clauses on detections of one object that are misplaced.

    Each detection is counted once, at the first of these that it is: at the
    camera, behind it, outside the image, or far from everything in the scene.

    Args:
        p_CO: (N, 3) positions in the camera's optical frame (in meters).
        camera: its image.
        X_WC: the camera's pose in the world.
        boxes: (B, 2, 3) around all that is known in the scene, see ModelFacts.
    """
    at_camera = np.linalg.norm(p_CO, axis=1) < _MIN_DISTANCE
    behind = ~at_camera & (p_CO[:, 2] <= 0)
    outside = ~at_camera & ~behind & ~in_or_near_image(p_CO, camera)
    distances = distances_to_boxes(_in_world(p_CO, X_WC), boxes)
    far = ~(at_camera | behind | outside) & (distances > _MAX_DISTANCE)
    kinds = (
        (f"at the camera, less than {_MIN_DISTANCE:g} m from it", at_camera),
        ("behind the camera", behind),
        ("outside the camera's image", outside),
        (f"more than {_MAX_DISTANCE:g} m from everything in the scene", far),
    )
    return [
        f"{np.count_nonzero(bad)} of {len(p_CO)} are {clause} (median "
        f"position {np.median(p_CO[bad], axis=0).round(3).tolist()} in the "
        "camera's optical frame: x right, y down, z forward, in meters); "
        f"{_remedy(p_CO[bad], X_WC, boxes)}"
        for clause, bad in kinds
        if np.count_nonzero(bad) > _MAX_SHARE * len(p_CO)
    ]


def _remedy(p_CO: np.ndarray, X_WC: RigidTransform, boxes: np.ndarray) -> str:
    """Returns what may be wrong with misplaced detections, as a clause."""
    for factor in _FACTORS if len(boxes) else ():
        p_WO = _in_world(factor * p_CO, X_WC)
        if np.median(distances_to_boxes(p_WO, boxes)) < _NEAR:
            return (
                f"times {factor:g} they would be near something: check the "
                "unit of the detector's positions"
            )
    return (
        "check the unit, the field that the detector writes the pose to, its "
        "frame, and the scene's camera"
    )


def _in_world(p_C: np.ndarray, X_WC: RigidTransform) -> np.ndarray:
    return p_C @ X_WC.rotation().matrix().T + X_WC.translation()


def in_or_near_image(p_CO: np.ndarray, camera: CameraConfig) -> np.ndarray:
    """Returns which points are in the image or just beside it, (N,) bool.

    Args:
        p_CO: (N, 3) points in the camera's optical frame (in meters).
        camera: its image.
    """
    z = np.where(p_CO[:, 2] > 0, p_CO[:, 2], np.nan)
    u = camera.fx * p_CO[:, 0] / z + camera.cx
    v = camera.fy * p_CO[:, 1] / z + camera.cy
    near = np.ones(len(p_CO), dtype=bool)
    for pixels, size in ((u, camera.width), (v, camera.height)):
        near &= (pixels > -_MARGIN * size) & (pixels < (1 + _MARGIN) * size)
    return near


def distances_to_boxes(p_W: np.ndarray, boxes: np.ndarray) -> np.ndarray:
    """Returns the distances to the nearest box (in meters), (N,).

    Without boxes nothing is known, and the distances are 0.

    Args:
        p_W: (N, 3) points in the world (in meters).
        boxes: (B, 2, 3) lowest and highest corners.
    """
    if not len(boxes):
        return np.zeros(len(p_W))
    nearest = np.clip(p_W[:, np.newaxis], boxes[:, 0], boxes[:, 1])
    return np.linalg.norm(p_W[:, np.newaxis] - nearest, axis=2).min(axis=1)
