"""Images as ROS messages have them, and as OpenCV does.

OpenCV's are (height, width, 3) of bytes: blue, green, red.
"""

from typing import Any

import cv2
import numpy as np

from pbpf_drake.bags.ros2_messages import IMAGE, short_type_name

# By encoding: bytes per pixel, and how to convert them.
_ENCODINGS: dict[str, tuple[int, int | None]] = {
    "bgr8": (3, None),
    "rgb8": (3, cv2.COLOR_RGB2BGR),
    "bgra8": (4, cv2.COLOR_BGRA2BGR),
    "rgba8": (4, cv2.COLOR_RGBA2BGR),
    "mono8": (1, cv2.COLOR_GRAY2BGR),
}
_JPEG_QUALITY = 85


def to_bgr(name: str, message: Any) -> np.ndarray:
    """Returns the image of a decoded message.

    Args:
        name: the type of the message, IMAGE or COMPRESSED_IMAGE.
        message: has the fields of its type.

    Raises:
        ValueError: it can't be converted; the message is a clause on why.
    """
    data = np.frombuffer(bytes(message.data), np.uint8)
    if short_type_name(name) == short_type_name(IMAGE):
        return _from_pixels(message, data)
    try:
        image = cv2.imdecode(data, cv2.IMREAD_COLOR)
    except cv2.error:
        image = None
    if image is None:
        raise ValueError(
            f"of format {message.format!r} that can't be decoded; expected "
            "jpeg or png"
        )
    return image


def _from_pixels(message: Any, data: np.ndarray) -> np.ndarray:
    if message.encoding not in _ENCODINGS:
        raise ValueError(
            f"of encoding {message.encoding!r}; expected one of "
            f"{list(_ENCODINGS)}"
        )
    depth, conversion = _ENCODINGS[message.encoding]
    height, width, step = message.height, message.width, message.step
    if len(data) != height * step or step < width * depth or not data.size:
        raise ValueError(
            f"with {len(data)} bytes for {width} x {height} pixels of "
            f"{depth} in rows of {step}"
        )
    rows = data.reshape(height, step)[:, : width * depth]
    pixels = np.ascontiguousarray(rows.reshape(height, width, depth))
    return pixels if conversion is None else cv2.cvtColor(pixels, conversion)


def jpeg_fields(image: np.ndarray) -> dict[str, Any]:
    """Returns the fields of a CompressedImage, without its header."""
    _, data = cv2.imencode(
        ".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY]
    )
    return {"format": "jpeg", "data": data.tobytes()}
