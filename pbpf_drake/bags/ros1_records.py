"""The records of a ROS 1 bag (format 2.0), and how to walk a damaged one.

A record is a header of named fields, and data. Records follow each other, in
the file and again within a chunk.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
import struct

BAG_MAGIC = b"#ROSBAG V2.0\n"
MESSAGE, HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION = 2, 3, 4, 5, 6, 7
_KINDS = {MESSAGE, HEADER, INDEX, CHUNK, CHUNK_INFO, CONNECTION}
_LENGTH = struct.Struct("<I")
# A header has numbers and the name of a topic (in bytes).
_MAX_HEADER = 4096
_TIME = struct.Struct("<II")
_ENTRY = struct.Struct("<III")


@dataclass(frozen=True)
class Record:
    """One record.

    Attributes:
        kind: one of the constants above.
        fields: the fields of its header.
        data: what follows the header; a part of what it was read from.
        begin, end: where it is.
    """

    kind: int
    fields: dict[str, bytes]
    data: memoryview
    begin: int
    end: int

    def Number(self, name: str) -> int:
        """Returns a field that is an unsigned integer; -1 if it is missing."""
        if name not in self.fields:
            return -1
        return int.from_bytes(self.fields[name], "little")

    def Text(self, name: str) -> str:
        """Returns a field that is a string."""
        return self.fields[name].decode()

    def Time(self) -> int:
        """Returns the field "time" (in nanoseconds); -1 if it is missing."""
        time = self.fields.get("time", b"")
        if len(time) != _TIME.size:
            return -1
        seconds, nanoseconds = _TIME.unpack(time)
        return seconds * 10**9 + nanoseconds


def walk_records(
    content: memoryview,
    *,
    begin: int,
    end: int,
    starts: Sequence[int],
    lost: Callable[[int, int], None],
) -> Iterator[Record]:
    """Yields the records between two places, and passes over what is damaged.

    Args:
        content: a file, or a chunk.
        begin, end: the two places.
        starts: where records are known to start, sorted: after damage the
            walk goes on at the next of them.
        lost: called with the begin and end of what could not be read.
    """
    while begin < end:
        record = _parse(content, begin, end)
        resume = _next_start(
            content, begin, record.end if record else end, starts
        )
        if record is not None and resume is None:
            yield record
            begin = record.end
        else:
            lost(begin, resume or end)
            begin = resume or end


def _next_start(
    content: memoryview, begin: int, end: int, starts: Sequence[int]
) -> int | None:
    """Returns the first known start strictly between with a record there."""
    for index in range(bisect_right(starts, begin), len(starts)):
        start = starts[index]
        if start >= end:
            break
        if _parse(content, start, len(content)):
            return start
    return None


def _parse(content: memoryview, begin: int, limit: int) -> Record | None:
    """Returns the record at one place, or None if it is not whole."""
    header_end = _end_of_block(content, begin, limit)
    data_end = header_end and _end_of_block(content, header_end, limit)
    if not header_end or not data_end:
        return None
    try:
        fields = _fields(content, begin, header_end)
        kind = fields["op"][0]
    except (KeyError, IndexError, ValueError):
        return None
    if kind not in _KINDS:
        return None
    data = content[header_end + _LENGTH.size : data_end]
    return Record(kind, fields, data, begin, data_end)


def _fields(
    content: memoryview, begin: int, header_end: int
) -> dict[str, bytes]:
    """Returns the fields of the header of a record.

    Raises:
        ValueError: it is damaged.
    """
    header = content[begin + _LENGTH.size : header_end]
    if len(header) > _MAX_HEADER:
        raise ValueError("it is too long")
    return parse_fields(bytes(header))


def _end_of_block(
    content: bytes | memoryview, begin: int, limit: int
) -> int | None:
    """Returns where a block, which starts with its length, ends."""
    after = begin + _LENGTH.size
    if after > limit:
        return None
    (length,) = _LENGTH.unpack(content[begin:after])
    return after + length if after + length <= limit else None


def parse_fields(header: bytes) -> dict[str, bytes]:
    """Returns the fields of a header.

    Raises:
        ValueError: it is damaged.
    """
    fields = {}
    begin = 0
    while begin < len(header):
        end = _end_of_block(header, begin, len(header))
        if end is None:
            raise ValueError("a field is not whole")
        field = header[begin + _LENGTH.size : end]
        name, equals, value = field.partition(b"=")
        if not equals:
            raise ValueError("a field has no name")
        fields[name.decode()] = value
        begin = end
    return fields


def index_entries(record: Record) -> Iterator[tuple[int, int, int]]:
    """Yields (connection, time in nanoseconds, offset) of an index record."""
    connection = record.Number("conn")
    usable = len(record.data) // _ENTRY.size * _ENTRY.size
    for seconds, nanoseconds, offset in _ENTRY.iter_unpack(
        record.data[:usable]
    ):
        yield connection, seconds * 10**9 + nanoseconds, offset


def whole_records(data: memoryview, begin: int) -> Iterator[Record]:
    """Yields records up to the first that is damaged."""
    return walk_records(
        data,
        begin=begin,
        end=len(data),
        starts=(),
        lost=lambda begin, end: None,
    )


def index_after(
    data: memoryview, begin: int
) -> Iterator[tuple[int, tuple[int, int]]]:
    """Yields what the index behind a chunk says of its messages.

    Yields:
        A message's offset in the chunk, and the number of its connection with
        its time (in nanoseconds).
    """
    for record in whole_records(data, begin):
        if record.kind != INDEX:
            return
        for connection, time, offset in index_entries(record):
            yield offset, (connection, time)


def cut_chunk(content: memoryview, begin: int) -> Record | None:
    """Returns the chunk at one place that the end of the file has cut off.

    Its data is what is left of it. None if there is something else.
    """
    header_end = _end_of_block(content, begin, len(content))
    after = (header_end or len(content)) + _LENGTH.size
    if header_end is None or after > len(content):
        return None
    try:
        fields = _fields(content, begin, header_end)
    except ValueError:
        return None
    if fields.get("op", b"")[:1] != bytes([CHUNK]):
        return None
    return Record(CHUNK, fields, content[after:], begin, len(content))


def has_checksum(chunk: Record) -> bool:
    """Tells if damage in a chunk shows when it is unpacked."""
    compression = chunk.Text("compression")
    # In lz4 it is optional: bit 2 of the byte after the magic tells.
    return compression == "bz2" or (
        compression == "lz4" and bool(chunk.data[4] & 0b100)
    )
