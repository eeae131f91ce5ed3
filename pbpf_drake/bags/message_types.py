"""Makes what decodes a type's messages, of the text that defines it."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

from pbpf_drake.bags.message_extent import MessageExtent
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, ReadLimits
from pbpf_drake.bags.ros2_messages import short_type_name
from pbpf_drake.bags.type_definitions import parse_definition

# Returns an object with a message's fields as attributes.
Decoder = Callable[[bytes], Any]
# How CDR says in which order the bytes of a number are.
_BIG, _LITTLE = b"\0\0", b"\0\1"
_CDR_HEADER = 4
# A message is filled up to a multiple of this many bytes.
_CDR_ALIGNMENT = 4


def make_ros1_decoder(
    kind: str, definition: str, limits: ReadLimits
) -> Decoder:
    """Returns what decodes messages of one type of ROS 1.

    Args:
        kind: the type's name.
        definition: its text, with that of all types in it.
        limits: for the text.

    Raises:
        Exception: of any kind, if the definition can't be used.
    """
    store, name = _store(kind, definition, limits.definition)
    extent = _extent(kind, definition, limits, aligned=False)

    def decode(data: bytes) -> Any:
        if extent.End(memoryview(data)) != len(data):
            raise ValueError("size mismatch: it is longer than its type")
        return store.deserialize_ros1(data, name)

    return decode


def make_ros2_decoder(
    kind: str, definition: str, limits: ReadLimits
) -> Decoder:
    """Returns what decodes messages of one type of ROS 2.

    A message has to be of this type from its first byte to its last, or it is
    refused.

    Args:
        kind: the type's name.
        definition: its text, with that of all types in it.
        limits: for the text.

    Raises:
        Exception: of any kind, if the definition can't be used.
    """
    store, name = _store(kind, definition, limits.definition)
    extent = _extent(kind, definition, limits, aligned=True)

    def decode(data: bytes) -> Any:
        if data[:2] not in (_BIG, _LITTLE):
            raise ValueError("it is not encoded as ROS 2 does")
        body = memoryview(data)[_CDR_HEADER:]
        end = extent.End(body, little_endian=data[:2] == _LITTLE)
        if len(body) - end >= _CDR_ALIGNMENT:
            raise ValueError(f"it ends at {end} of {len(body)} bytes")
        return store.deserialize_cdr(data, name)

    return decode


def _extent(
    kind: str, definition: str, limits: ReadLimits, *, aligned: bool
) -> MessageExtent:
    types = parse_definition(kind, definition, limits.definition)
    return MessageExtent(types, short_type_name(kind), aligned=aligned)


@lru_cache(maxsize=1000)
def definition_matches(
    kind: str,
    definition: str,
    checksum: str,
    limits: ReadLimits = DEFAULT_LIMITS,
) -> bool:
    """Tells if a definition has the MD5 sum that ROS 1 gives it."""
    try:
        store, name = _store(kind, definition, limits.definition)
        # "*" stands for any.
        return checksum in ("*", store.generate_msgdef(name)[1])
    except Exception:  # Damage can show in any way.
        return False


@lru_cache(maxsize=1000)
def _store(kind: str, definition: str, limit: int) -> tuple[Any, str]:
    """Returns a store of types with this one in it, and its name there."""
    # It makes Python of the text: nothing may get there unchecked.
    parse_definition(kind, definition, limit)
    # It takes a while to import, and only logs need it.
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    name = kind if "/msg/" in kind else kind.replace("/", "/msg/")
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition, name))
    return store, name
