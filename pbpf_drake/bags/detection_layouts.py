"""Decodes detections of any release, where the log doesn't say of which.

The type vision_msgs/Detection3DArray was changed from release to release, and
ROS 2 bags before Jazzy don't have its definition. So all layouts are tried: the
one that a message fits from its first byte to its last is the right one.
"""

from dataclasses import fields, is_dataclass
import math
from typing import Any

import numpy as np

from pbpf_drake.bags.message_types import Decoder, make_ros2_decoder
from pbpf_drake.bags.read_limits import ReadLimits
from pbpf_drake.bags.ros2_messages import DETECTION_ARRAY, message_definition

_SEPARATOR = "\n" + "=" * 80 + "\n"
_POINT_FIELD = "string name\nuint32 offset\nuint8 datatype\nuint32 count"
_CLOUD = """std_msgs/Header header
uint32 height
uint32 width
sensor_msgs/PointField[] fields
bool is_bigendian
uint32 point_step
uint32 row_step
uint8[] data
bool is_dense"""
# Numbers of classes are small, and eight letters are not (for an integer of
# eight bytes).
_MAX_INTEGER = 2**40
_HUMBLE = "that of ROS 2 Humble"


def old_definition(id_type: str, *, tracking: bool) -> str:
    """Returns the definition of an array of detections before Humble.

    Args:
        id_type: of an object's class, "string" or "int64".
        tracking: whether a detection says if it was tracked.
    """
    first, *others = message_definition(DETECTION_ARRAY).split(_SEPARATOR)
    result = f"{id_type} id\nfloat64 score\ngeometry_msgs/PoseWithCovariance"
    changed = {
        "vision_msgs/ObjectHypothesisWithPose": f"{result} pose",
        "vision_msgs/Detection3D": "std_msgs/Header header\n"
        "vision_msgs/ObjectHypothesisWithPose[] results\n"
        "vision_msgs/BoundingBox3D bbox\n"
        "sensor_msgs/PointCloud2 source_cloud"
        + ("\nbool is_tracking\nstring tracking_id" if tracking else ""),
        "sensor_msgs/PointCloud2": _CLOUD,
        "sensor_msgs/PointField": _POINT_FIELD,
    }
    kept = [t for t in others if t.split()[1] not in changed]
    texts = [f"MSG: {name}\n{text}" for name, text in changed.items()]
    return _SEPARATOR.join([first, *kept, *texts])


def _layouts() -> dict[str, str]:
    """Returns definitions by what they are; the first is the likeliest."""
    return {
        _HUMBLE: message_definition(DETECTION_ARRAY),
        "that of ROS 2 Foxy": old_definition("string", tracking=True),
        "one before Foxy": old_definition("string", tracking=False),
        "that of ROS 1 Noetic": old_definition("int64", tracking=True),
        "that of ROS 1 Melodic": old_definition("int64", tracking=False),
    }


class DetectionLayouts:
    """Decodes arrays of detections, all of which are of one layout."""

    def __init__(self, limits: ReadLimits):
        """Starts with all layouts.

        Args:
            limits: for the text of a definition.
        """
        self._decoders: dict[str, Decoder] = {
            name: make_ros2_decoder(DETECTION_ARRAY, text, limits)
            for name, text in _layouts().items()
        }

    def Decode(self, data: bytes) -> Any:
        """Returns an object with the message's fields as attributes.

        Raises:
            ValueError: the message doesn't fit the layout, or any of them.
        """
        found = {}
        for name, decode in self._decoders.items():
            message = decode_plausible(decode, data)
            if message is not None:
                found[name] = message
        if not found:
            raise ValueError("it fits no layout of detections")
        # A number may look like an empty name, which no class has.
        named = {n: m for n, m in found.items() if _has_names(m)}
        found = named or found
        # An empty array fits them all, and tells nothing.
        if len(found) == 1:
            self._decoders = {name: self._decoders[name] for name in found}
        return next(iter(found.values()))

    def Sentence(self) -> str:
        """Returns what layout the detections have; empty for today's."""
        if len(self._decoders) != 1 or _HUMBLE in self._decoders:
            return ""
        (name,) = self._decoders
        return (
            "the log has no definition of vision_msgs/Detection3DArray: of "
            f"the layouts that are known, only {name} fits, and was used"
        )


def _has_names(message: Any) -> bool:
    """Tells if all results of an array say what they are of."""
    results = [r for d in message.detections for r in d.results]
    ids = [
        result.hypothesis.class_id
        if hasattr(result, "hypothesis")
        else result.id
        for result in results
    ]
    return "" not in ids


def decode_plausible(decode: Decoder, data: bytes) -> Any:
    """Returns what a message says, or None if it is hardly of this type.

    Args:
        decode: decodes messages of a type that may not be the message's.
        data: the message.
    """
    try:
        message = decode(data)
    except Exception:  # What doesn't fit can show in any way.
        return None
    return message if _is_plausible(message) else None


def _is_plausible(value: Any) -> bool:
    """Tells if texts can be read, and single numbers are no bits of texts."""
    if isinstance(value, str):
        return value.isprintable()
    if isinstance(value, int):
        return abs(value) <= _MAX_INTEGER
    if isinstance(value, float):
        return value == 0 or 1e-100 < abs(value) < 1e100 or math.isnan(value)
    if isinstance(value, np.ndarray):
        return True
    if isinstance(value, list):
        return all(_is_plausible(item) for item in value)
    if is_dataclass(value):
        return all(
            _is_plausible(getattr(value, field.name)) for field in fields(value)
        )
    return True
