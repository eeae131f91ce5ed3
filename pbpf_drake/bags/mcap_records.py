"""The records of an MCAP file, and how to walk a damaged one.

A record is a kind, a length and content. Records follow each other, in the
file and again within a chunk.
"""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
import mmap
import struct
import zlib

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    McapRecord,
    Schema,
    Statistics,
)

MCAP_MAGIC = b"\x89MCAP0\r\n"
RECORD_HEADER = struct.Struct("<BQ")
# Of a message: channel, number, when received, when sent.
_MESSAGE = struct.Struct("<HIQQ")
# Of a chunk: first and last time, length and checksum of what is in it.
_CHUNK = struct.Struct("<QQQI")
# The end of a file: the fields of the footer, and the magic.
_END = struct.Struct("<QQI8s")
# Of a record that is neither a message nor a chunk (in bytes).
_MAX_RECORD = 2**21
_PARSERS: dict[int, Callable[[ReadDataStream], McapRecord]] = {
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK_INDEX: ChunkIndex.read,
    Opcode.DATA_END: DataEnd.read,
    Opcode.SCHEMA: Schema.read,
    Opcode.STATISTICS: Statistics.read,
}

# A file, or what is in a chunk.
Content = mmap.mmap | memoryview | bytes | bytearray


@dataclass(frozen=True)
class Place:
    """Where a record is, with its kind.

    Attributes:
        opcode: its kind.
        begin, end: of its content.
    """

    opcode: int
    begin: int
    end: int


@dataclass(frozen=True)
class McapMessage:
    """A message; ``data`` is a part of what it was read from."""

    channel_id: int
    log_time: int
    data: memoryview


@dataclass(frozen=True)
class McapChunk:
    """A chunk.

    Attributes:
        size: how long its records are, unpacked (in bytes).
        crc: their checksum; 0 where there is none.
        compression: "zstd", "lz4" or "".
        packed: the records; a part of what the chunk was read from.
        missing: how many bytes of ``packed`` are beyond the end.
    """

    size: int
    crc: int
    compression: str
    packed: memoryview
    missing: int


def walk_records(
    content: Content, begin: int, starts: Sequence[int] = ()
) -> Iterator[Place]:
    """Yields the place of every whole record from ``begin``.

    After damage it goes on at the next of the places where chunks are known
    to start; otherwise it ends there.

    Args:
        content: a file, or what is in a chunk.
        begin: where to start.
        starts: where chunks are known to start, sorted.
    """
    while True:
        place = _record_at(content, begin)
        end = place.end if place else len(content)
        resume = _next_chunk(content, begin, end, starts)
        if resume is not None:
            # What is passed over shows when messages are counted.
            begin = resume
        elif place is None:
            return
        else:
            yield place
            begin = place.end


def _record_at(content: Content, begin: int) -> Place | None:
    """Returns the record at one place, if it is whole."""
    after = begin + RECORD_HEADER.size
    if after > len(content):
        return None
    opcode, length = RECORD_HEADER.unpack(content[begin:after])
    whole = after + length <= len(content)
    return Place(opcode, after, after + length) if whole else None


def _next_chunk(
    content: Content, begin: int, end: int, starts: Sequence[int]
) -> int | None:
    """Returns the first known start strictly between with a chunk there."""
    for index in range(bisect_right(starts, begin), len(starts)):
        start = starts[index]
        if start >= end:
            break
        if content[start] == Opcode.CHUNK and _record_at(content, start):
            return start
    return None


def parse_record(opcode: int, content: memoryview) -> McapRecord | None:
    """Returns a record; None for a kind that is of no use here.

    Raises:
        Exception: of any kind, if it is damaged.
    """
    if opcode not in _PARSERS:
        return None
    if len(content) > _MAX_RECORD:
        raise ValueError("the record is too long")
    return _PARSERS[opcode](ReadDataStream(BytesIO(content)))


def parse_message(content: memoryview) -> McapMessage:
    """Returns what a record of a message holds.

    Raises:
        struct.error: it is too short.
    """
    channel, _, log_time, _ = _MESSAGE.unpack_from(content)
    return McapMessage(channel, log_time, content[_MESSAGE.size :])


def parse_chunk(content: memoryview) -> McapChunk:
    """Returns what a record of a chunk holds, also where its end is missing.

    Raises:
        Exception: of any kind, if it is damaged.
    """
    _, _, size, crc = _CHUNK.unpack_from(content)
    at = _CHUNK.size
    (length,) = struct.unpack_from("<I", content, at)
    at += 4
    compression = bytes(content[at : at + length]).decode()
    at += length
    (length,) = struct.unpack_from("<Q", content, at)
    packed = content[at + 8 :][:length]
    return McapChunk(size, crc, compression, packed, length - len(packed))


def check_records(chunk: McapChunk, records: Content) -> None:
    """Checks what was unpacked of a chunk.

    Raises:
        ValueError: its checksum is wrong, or without one its length.
    """
    if chunk.missing:
        raise ValueError("its end is missing")
    if chunk.crc and chunk.crc != zlib.crc32(records):
        raise ValueError("its checksum is wrong")
    if not chunk.crc and chunk.size != len(records):
        raise ValueError("its length is wrong")


def cut_chunk(content: memoryview, begin: int) -> McapChunk | None:
    """Returns the chunk at one place that the end of the file has cut off.

    None if there is something else, or if its two lengths don't agree: then
    one of them is damaged, and nothing is known to be cut off.
    """
    after = begin + RECORD_HEADER.size
    if after > len(content) or content[begin] != Opcode.CHUNK:
        return None
    _, length = RECORD_HEADER.unpack(content[begin:after])
    try:
        chunk = parse_chunk(content[after:])
    except (struct.error, UnicodeDecodeError):
        return None
    missing = after + length - len(content)
    return chunk if chunk.missing == missing > 0 else None


def find_summary(content: Content) -> int | None:
    """Returns where a file's summary starts, if there is one that is whole."""
    if len(content) < _END.size:
        return None
    start, _, crc, magic = _END.unpack(content[-_END.size :])
    if magic != MCAP_MAGIC or not 0 < start < len(content):
        return None
    # The checksum covers all up to itself.
    if crc not in (0, zlib.crc32(content[start : len(content) - 12])):
        return None
    return start
