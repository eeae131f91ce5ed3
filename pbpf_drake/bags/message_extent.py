"""Finds where a message ends, before it is decoded.

What a message says of the length of its own arrays may be damaged, or made to
fill the memory. Here each length is checked with what is left of the message.
"""

import struct

from pbpf_drake.bags.type_definitions import PRIMITIVES, STRING, Field, Types

_LENGTH_SIZE = 4


class MessageExtent:
    """Walks the messages of one type."""

    def __init__(self, types: Types, name: str, *, aligned: bool):
        """Prepares to walk messages.

        Args:
            types: that are in the message, and its own.
            name: of its own, "package/Type".
            aligned: whether numbers are aligned and strings end with a zero,
                as in ROS 2.
        """
        self._types = types
        self._name = name
        self._aligned = aligned

    def End(self, data: memoryview, *, little_endian: bool = True) -> int:
        """Returns where a message ends in ``data``.

        Raises:
            ValueError: it would end behind ``data``, or a string in it has no
                end.
        """
        length = struct.Struct("<I" if little_endian else ">I")
        return self._Type(self._name, data, 0, length)

    def _Type(
        self, name: str, data: memoryview, at: int, length: struct.Struct
    ) -> int:
        for field in self._types[name]:
            at = self._Field(field, data, at, length)
        return at

    def _Field(
        self, field: Field, data: memoryview, at: int, length: struct.Struct
    ) -> int:
        count = field.count
        if count is None:
            count, at = self._Number(data, at, length)
            if count > len(data) - at:
                raise ValueError(f"{count} of {field.type} are too many")
        if field.type in PRIMITIVES:
            size, alignment = PRIMITIVES[field.type]
            if count:
                at = self._Align(at, alignment) + count * size
        elif field.type == STRING:
            for _ in range(count):
                at = self._String(data, at, length)
        else:
            for _ in range(count):
                at = self._Type(field.type, data, at, length)
        if at > len(data):
            raise ValueError(f"{field.type} ends behind the message")
        return at

    def _String(self, data: memoryview, at: int, length: struct.Struct) -> int:
        count, at = self._Number(data, at, length)
        end = at + count
        # Some write an empty string without its zero.
        if end > len(data) or (self._aligned and count and data[end - 1]):
            raise ValueError("a string has no end")
        return end

    def _Number(
        self, data: memoryview, at: int, length: struct.Struct
    ) -> tuple[int, int]:
        """Returns the length at one place, and where it ends."""
        at = self._Align(at, _LENGTH_SIZE)
        if at + _LENGTH_SIZE > len(data):
            raise ValueError("a length is behind the message")
        return length.unpack_from(data, at)[0], at + _LENGTH_SIZE

    def _Align(self, at: int, size: int) -> int:
        return -(-at // size) * size if self._aligned else at
