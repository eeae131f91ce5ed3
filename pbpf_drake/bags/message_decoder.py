"""Decodes the messages of ROS 1 and ROS 2."""

from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from typing import Any

from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
import zstandard

from pbpf_drake.bags.log_stream import RawMessage
from pbpf_drake.bags.ros1_decoding import make_ros1_decoder
from pbpf_drake.bags.ros2_messages import (
    is_known,
    is_stable,
    message_definition,
)
from pbpf_drake.bags.zstd_stream import ZSTD_MAGIC

# A message that claims to be longer is damaged (in bytes).
_MAX_LENGTH = 2**30

_Decode = Callable[[bytes], Any]


class MessageDecoder:
    """Decodes messages, whose types may differ."""

    def __init__(self) -> None:
        """Starts without types."""
        self._decoders: dict[tuple[str, str, str], _Decode | None] = {}

    def Decode(self, message: RawMessage) -> Any:
        """Returns an object with the message's fields as attributes.

        Raises:
            Exception: of any kind, if the message or its definition is
                damaged, or it is encoded in another way.
        """
        key = message.encoding, message.type, message.definition
        if key not in self._decoders:
            # A definition that can't be used is tried only once.
            self._decoders[key] = None
            self._decoders[key] = _make_decoder(*key)
        decode = self._decoders[key]
        if decode is None:
            raise ValueError("no decoder")
        return decode(_unpack(message.data))


def _make_decoder(encoding: str, kind: str, definition: str) -> _Decode:
    if encoding == "ros1":
        return make_ros1_decoder(kind, definition)
    if encoding != "cdr":
        raise ValueError(f"messages are encoded as {encoding!r}")
    # A definition in the file may be damaged or missing, these can't.
    if is_stable(kind) or (not definition and is_known(kind)):
        definition = message_definition(kind)
    schema = Schema(
        id=1, data=definition.encode(), encoding="ros2msg", name=kind
    )
    # The library prints what it thinks of a damaged definition.
    with redirect_stderr(StringIO()), redirect_stdout(StringIO()):
        decode = DecoderFactory().decoder_for("cdr", schema)
    if decode is None:
        raise ValueError("no definition")
    return decode


def _unpack(data: bytes) -> bytes:
    """Returns the message in a compressed one, as rosbag2 can write them."""
    if not data.startswith(ZSTD_MAGIC):
        return data
    if zstandard.frame_content_size(data) > _MAX_LENGTH:
        raise ValueError("the message is too long")
    return zstandard.ZstdDecompressor().decompress(
        data, max_output_size=_MAX_LENGTH
    )
