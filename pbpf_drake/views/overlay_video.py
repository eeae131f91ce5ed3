"""Writes images as an MP4 file."""

from pathlib import Path

import cv2
import numpy as np

# The lowest and the highest rate of images that MPEG-4 can write (in 1/s).
_RATES = (0.01, 500.0)
# The largest width and height of its images (in pixels).
_MAX_SIZE = 8_191


class OverlayVideo:
    """An MP4 file that is being written; a context manager."""

    def __init__(
        self, filename: str | Path, *, width: int, height: int, period: float
    ):
        """Opens the file.

        Args:
            filename: the file to write; its folder must exist.
            width, height: of every image (in pixels).
            period: time between two images (in seconds).

        Raises:
            ValueError: OpenCV can't write such a file.
        """
        rate = round(float(np.clip(1 / period, *_RATES)), 2)
        self._writer = cv2.VideoWriter()
        if max(width, height) <= _MAX_SIZE:
            code = cv2.VideoWriter.fourcc(*"mp4v")
            self._writer.open(str(filename), code, rate, (width, height))
        if not self._writer.isOpened():
            raise ValueError(
                f"{filename} can't be written as MP4 with images of "
                f"{width} x {height} pixels; expected a file that can be "
                f"written, and from 2 to {_MAX_SIZE:,} pixels each way"
            )

    def Write(self, image: np.ndarray) -> None:
        """Adds an image (height, width, 3): blue, green, red."""
        self._writer.write(image)

    def __enter__(self) -> "OverlayVideo":
        """Returns the video."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Completes the file."""
        self._writer.release()
