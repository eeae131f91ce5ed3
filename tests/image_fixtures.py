"""Logs of the planar push with images of a camera."""

from collections.abc import Callable
from pathlib import Path

from bag_fixtures import Entry, our_entries, write_mcap
import cv2
import numpy as np

from pbpf_drake.log import Log
from pbpf_drake.ros2_messages import header_message

TOPIC = "/camera/color/image_raw"
# Time (in seconds), topic, type, message without its header.
TimedImage = tuple[float, str, str, dict]


def raw_image(image: np.ndarray, encoding: str = "bgr8", pad: int = 0) -> dict:
    """Returns the fields of an Image; rows have ``pad`` bytes behind them."""
    height, width = image.shape[:2]
    rows = np.pad(image.reshape(height, -1), ((0, 0), (0, pad)))
    return {
        "height": height,
        "width": width,
        "encoding": encoding,
        "step": rows.shape[1],
        "data": rows.tobytes(),
    }


def png_image(image: np.ndarray) -> dict:
    """Returns the fields of a CompressedImage without loss."""
    data = cv2.imencode(".png", image)[1].tobytes()
    return {"format": "png", "data": data}


def flat_image(shade: int, size: tuple[int, int] = (640, 480)) -> np.ndarray:
    """Returns an image (width, height) of one shade of grey."""
    return np.full((size[1], size[0], 3), shade, np.uint8)


def image_entries(log: Log, images: list[TimedImage]) -> list[Entry]:
    """Returns images as messages, received 20 ms after their stamp."""
    entries = []
    for time, topic, kind, message in images:
        stamp = log.start_time + round(1e9 * time)
        header = header_message(stamp=stamp, frame_id="camera")
        message = {"header": header, **message}
        entries.append((stamp + 20_000_000, topic, kind, message))
    return entries


def write_log(
    path: Path,
    log: Log,
    images: list[TimedImage],
    write: Callable[[Path, list[Entry]], Path] = write_mcap,
) -> Path:
    """Writes a log with images."""
    entries = our_entries(log) + image_entries(log, images)
    return write(path, sorted(entries, key=lambda entry: entry[0]))
