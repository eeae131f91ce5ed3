"""Decodes the messages of ROS 1 and ROS 2."""

from typing import Any

from pbpf_drake.bags.detection_layouts import DetectionLayouts
from pbpf_drake.bags.log_stream import RawMessage
from pbpf_drake.bags.message_types import (
    Decoder,
    make_ros1_decoder,
    make_ros2_decoder,
)
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, LimitError, ReadLimits
from pbpf_drake.bags.ros2_messages import (
    COMPRESSED_IMAGE,
    DETECTION_ARRAY,
    IMAGE,
    is_known,
    is_one_of,
    is_stable,
    message_definition,
)
from pbpf_drake.bags.unpacking import unpack
from pbpf_drake.bags.zstd_stream import ZSTD_MAGIC


class MessageDecoder:
    """Decodes messages, whose types may differ."""

    def __init__(self, limits: ReadLimits = DEFAULT_LIMITS, size: int = 0):
        """Starts without types.

        Args:
            limits: what is decoded at most.
            size: of the file that the messages are from (in bytes).
        """
        self._limits = limits
        # How much may still be decoded, and unpacked for it.
        self._left = limits.max_decoded(size)
        self._left_packed = limits.max_unpacked(size)
        self._left_definitions = limits.definitions
        self._decoders: dict[tuple[str, str, str], Decoder | None] = {}
        self._layouts: DetectionLayouts | None = None

    def Decode(self, message: RawMessage) -> Any:
        """Returns an object with the message's fields as attributes.

        Raises:
            LimitError: with it too much would be decoded.
            Exception: of any kind, if the message or its definition is
                damaged, or it is encoded in another way.
        """
        key = message.encoding, message.type, message.definition
        if key not in self._decoders:
            length = len(message.definition)
            # One that is too long is not looked at.
            if length <= self._limits.definition:
                self._left_definitions -= length
            if self._left_definitions < 0:
                raise LimitError(
                    "whose types have too long definitions; see "
                    "ReadLimits.definitions"
                )
            # A definition that can't be used is tried only once.
            self._decoders[key] = None
            self._decoders[key] = self._MakeDecoder(*key)
        decode = self._decoders[key]
        if decode is None:
            raise ValueError("no decoder")
        data = self._Unpack(message.data)
        # Pixels are not looked at here.
        if not is_one_of(message.type, (IMAGE, COMPRESSED_IMAGE)):
            self._Count(len(data))
        return decode(data)

    def Sentences(self) -> list[str]:
        """Returns a sentence for everything that was assumed so far."""
        said = self._layouts.Sentence() if self._layouts else ""
        return [said] if said else []

    def _MakeDecoder(
        self, encoding: str, kind: str, definition: str
    ) -> Decoder:
        if encoding == "ros1":
            return make_ros1_decoder(kind, definition, self._limits)
        if encoding != "cdr":
            raise ValueError(f"messages are encoded as {encoding!r}")
        # A definition in the file may be damaged or missing, these can't.
        if is_stable(kind):
            definition = message_definition(kind)
        try:
            return make_ros2_decoder(kind, definition, self._limits)
        except Exception:  # Damage can show in any way.
            if is_one_of(kind, (DETECTION_ARRAY,)):
                self._layouts = DetectionLayouts(self._limits)
                return self._layouts.Decode
            if not is_known(kind):
                raise
        return make_ros2_decoder(kind, message_definition(kind), self._limits)

    def _Unpack(self, data: bytes) -> bytes:
        """Returns the message in one that rosbag2 has compressed."""
        if not data.startswith(ZSTD_MAGIC):
            return data
        limit = min(self._limits.message, self._left_packed)
        self._left_packed -= limit
        try:
            found = unpack("zstd", data, limit).content
        except LimitError:
            if limit == self._limits.message:
                raise
            raise LimitError(
                "beyond what a log of this size may unpack to; see "
                "ReadLimits.unpacked"
            ) from None
        self._left_packed += limit - len(found)
        return bytes(found)

    def _Count(self, length: int) -> None:
        self._left -= length
        if self._left < 0:
            raise LimitError(
                "beyond what is decoded of a log of this size; see "
                "ReadLimits.decoded"
            )
