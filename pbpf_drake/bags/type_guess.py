"""Finds out what type messages have, where the file doesn't say."""

from pbpf_drake.bags.detection_layouts import (
    DetectionLayouts,
    decode_plausible,
)
from pbpf_drake.bags.message_types import Decoder, make_ros2_decoder
from pbpf_drake.bags.read_limits import ReadLimits
from pbpf_drake.bags.ros2_messages import (
    COMPRESSED_IMAGE,
    DETECTION_ARRAY,
    IMAGE,
    JOINT_STATE,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    TF_MESSAGE,
    TRANSFORM_STAMPED,
    message_definition,
)

# An empty array of detections may also be other things that are empty.
_TYPES = (
    JOINT_STATE,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    TRANSFORM_STAMPED,
    TF_MESSAGE,
    IMAGE,
    COMPRESSED_IMAGE,
)
# After so many messages that fit no type, no more are looked at.
_PATIENCE = 20


class TypeGuess:
    """The type of the messages on one topic of a ROS 2 log.

    Attributes:
        type: the type that they have, as far as one can tell; empty where
            none fits.
    """

    def __init__(self, limits: ReadLimits):
        """Starts with all types that are known.

        Args:
            limits: for the text of a definition.
        """
        self.type = ""
        self._patience = _PATIENCE
        self._decoders: dict[str, Decoder] = {
            DETECTION_ARRAY: DetectionLayouts(limits).Decode,
            **{
                kind: make_ros2_decoder(kind, message_definition(kind), limits)
                for kind in _TYPES
            },
        }

    def Look(self, data: bytes) -> str:
        """Looks at one more message, and returns what type it has.

        Args:
            data: the message.
        """
        if len(self._decoders) > 1 and self._patience:
            fitting = {
                kind: decode
                for kind, decode in self._decoders.items()
                if decode_plausible(decode, data) is not None
            }
            self._decoders = fitting or self._decoders
            self._patience -= not fitting
            self.type = next(iter(fitting), self.type)
        return self.type

    def Sentence(self) -> str:
        """Returns what is said of a guess that was made."""
        return (
            "the file does not say of what type its messages are: they are "
            f"read as {self.type}, which fits them"
        )
