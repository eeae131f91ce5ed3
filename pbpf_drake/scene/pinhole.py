"""Where a pinhole camera sees points and segments.

The camera's optical frame C has z forward, x right and y down. The centre of
the image's first pixel is (0, 0).
"""

import numpy as np

from pbpf_drake.config.camera_config import CameraConfig

# Whatever is nearer to the camera than this (in meters) is not drawn.
_NEAR = 0.01


def in_camera(p_W: np.ndarray, camera: CameraConfig) -> np.ndarray:
    """Returns points in the camera's frame (in meters), (..., 3).

    Args:
        p_W: points in the world (in meters), (..., 3).
        camera: its pose.
    """
    X_CW = camera.pose().inverse()
    return p_W @ X_CW.rotation().matrix().T + X_CW.translation()


def project_points(p_C: np.ndarray, camera: CameraConfig) -> np.ndarray:
    """Returns where points are in the image (in pixels), (..., 2).

    Args:
        p_C: points in front of the camera, in its frame (in meters), (..., 3).
        camera: its intrinsics.
    """
    focal, centre = [camera.fx, camera.fy], [camera.cx, camera.cy]
    return p_C[..., :2] / p_C[..., 2:] * focal + centre


def in_image(p_C: np.ndarray, camera: CameraConfig) -> np.ndarray:
    """Returns which points the image has a pixel for, (...).

    The centre of the first pixel is (0, 0), so that the image reaches from
    -0.5 to width - 0.5 and height - 0.5, as in ROS, OpenCV and Drake.

    Args:
        p_C: points in the camera's frame (in meters), (..., 3).
        camera: its intrinsics.
    """
    ahead = p_C[..., 2] > 0
    z = np.where(ahead, p_C[..., 2], 1.0)
    # As 0.5 is added first, this is not rounded like project_points(p_C) + 0.5,
    # and at the very edge of the image the two may differ.
    u = camera.cx + 0.5 + camera.fx * p_C[..., 0] / z
    v = camera.cy + 0.5 + camera.fy * p_C[..., 1] / z
    return (
        ahead & (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    )


def project_segments(
    segments_W: np.ndarray, camera: CameraConfig
) -> np.ndarray:
    """Returns those parts of segments that are in the image, (E', 2, 2).

    Args:
        segments_W: E segments in the world (in meters), (E, 2, 3).
        camera: its pose and intrinsics.

    Returns:
        Their ends (in pixels), none of them outside of the image.
    """
    segments_C = in_camera(segments_W, camera)
    for normal, offset in _frustum(camera):
        segments_C = clip_segments(segments_C, normal, offset)
    return project_points(segments_C, camera)


def clip_segments(
    segments: np.ndarray, normal: np.ndarray, offset: float
) -> np.ndarray:
    """Returns those parts of segments that are on one side of a plane.

    Points p are kept where normal · p ≥ offset.

    Args:
        segments: (E, 2, 3).
        normal: (3,) of any length.
        offset: see above.
    """
    heights = segments @ normal - offset
    kept = heights.max(axis=1, initial=-np.inf) >= 0
    segments, heights = segments[kept], heights[kept]
    # Where one end is on the wrong side, it moves to the plane: by a share of
    # the segment's length, 0 < share ≤ 1.
    wrong = heights < 0
    rows = np.flatnonzero(wrong.any(axis=1))
    ends = wrong[rows].argmax(axis=1)
    bad, good = heights[rows, ends], heights[rows, 1 - ends]
    share = (bad / (bad - good))[:, None]
    clipped = segments.copy()
    clipped[rows, ends] += share * (
        segments[rows, 1 - ends] - segments[rows, ends]
    )
    return clipped


def _frustum(camera: CameraConfig) -> list[tuple[np.ndarray, float]]:
    """Returns the planes that bound what the camera sees.

    Each is a normal and an offset, as ``clip_segments`` takes them.
    """
    left, right = camera.cx + 0.5, camera.width - 0.5 - camera.cx
    top, bottom = camera.cy + 0.5, camera.height - 0.5 - camera.cy
    return [
        (np.array([0.0, 0.0, 1.0]), _NEAR),
        (np.array([camera.fx, 0.0, left]), 0.0),
        (np.array([-camera.fx, 0.0, right]), 0.0),
        (np.array([0.0, camera.fy, top]), 0.0),
        (np.array([0.0, -camera.fy, bottom]), 0.0),
    ]
