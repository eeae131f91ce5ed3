"""Draws what the camera sees, with the paper's wireframes.

Images are (height, width, 3) of bytes: blue, green, red, as OpenCV has them.
"""

from collections.abc import Sequence

import cv2
import numpy as np

from pbpf_drake.config.scene_config import CameraConfig
from pbpf_drake.scene.pinhole import project_segments

ESTIMATE_COLOR = (90, 224, 25)
DETECTION_COLOR = (0, 213, 255)
SURROUNDINGS_COLOR = (110, 110, 110)
BACKGROUND_COLOR = (40, 40, 40)
# Coordinates of lines are given in steps of 1/16 of a pixel.
_SHIFT = 4


def plain_image(camera: CameraConfig) -> np.ndarray:
    """Returns an image of nothing."""
    return np.full((camera.height, camera.width, 3), BACKGROUND_COLOR, np.uint8)


def draw_edges(
    image: np.ndarray,
    edges_W: np.ndarray,
    camera: CameraConfig,
    *,
    color: Sequence[int],
    width: int = 1,
) -> None:
    """Draws edges into an image, as far as the camera sees them.

    Args:
        image: to draw into.
        edges_W: segments in the world (in meters), (E, 2, 3).
        camera: that has taken the image.
        color: blue, green, red, from 0 to 255.
        width: of the lines (in pixels).
    """
    lines = project_segments(edges_W, camera) * 2**_SHIFT
    cv2.polylines(
        image,
        list(np.rint(lines).astype(np.int32)),
        isClosed=False,
        color=color,
        thickness=width,
        lineType=cv2.LINE_AA,
        shift=_SHIFT,
    )
