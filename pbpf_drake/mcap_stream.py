"""Reads the messages of an MCAP file, also of one that is damaged.

A file is walked record by record. Every chunk of messages carries a checksum:
a chunk that fails it is left out and the next one is read. A file that was cut
off is used up to there. The file's own count of messages tells what is
missing. Nothing is left out without a sentence in ``damage``.
"""

from collections import Counter
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from io import BytesIO
import mmap
from pathlib import Path
import struct
import zlib

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    DataEnd,
    McapRecord,
    Message,
    Schema,
    Statistics,
)
from mcap.stream_reader import breakup_chunk

from pbpf_drake.log_error import LogError
from pbpf_drake.log_notes import plural

_MAGIC = b"\x89MCAP0\r\n"
_RECORD_HEADER = struct.Struct("<BQ")
# The end of a file: the fields of the footer, and the magic.
_END = struct.Struct("<QQI8s")
_OTHER_FORMATS = {
    b"#ROSBAG V": "a ROS 1 bag",
    b"SQLite format 3": "a ROS 2 bag of the storage sqlite3",
}
_PARSERS: dict[int, Callable[[ReadDataStream], McapRecord]] = {
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.DATA_END: DataEnd.read,
    Opcode.SCHEMA: Schema.read,
    Opcode.STATISTICS: Statistics.read,
}


@dataclass(frozen=True)
class RawMessage:
    """A message as the file holds it.

    Attributes:
        topic: its topic.
        encoding: how ``data`` is encoded: "cdr" for ROS 2.
        schema: the definition of its type; None where the file has none.
        log_time: when it was received (in nanoseconds).
        data: the encoded message.
    """

    topic: str
    encoding: str
    schema: Schema | None
    log_time: int
    data: bytes


class McapStream:
    """The messages of one file on given topics, in the file's order.

    After ``Messages()`` is exhausted the other two attributes are complete.

    Attributes:
        types: by topic, the name of the type of its messages; all topics.
        damage: one sentence for everything that could not be read.
    """

    def __init__(self, *, filename: Path, topics: Collection[str]):
        """Prepares to read a file.

        Args:
            filename: the file.
            topics: the topics whose messages to return.
        """
        self.types: dict[str, str] = {}
        self.damage: list[str] = []
        self._filename = filename
        self._topics = topics
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._promised: dict[int, int] = {}
        self._found: Counter[int] = Counter()

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: there is no such file, or it is not an MCAP file.
        """
        with _open(self._filename) as data:
            self._ReadSummary(data)
            yield from self._ReadData(data)
        self._CompareCounts()

    def _ReadSummary(self, data: mmap.mmap) -> None:
        # It repeats schemas and channels, whose first copies may be damaged.
        start = _summary_start(data)
        if start is None:
            return
        for opcode, body, _ in _records(data, start):
            try:
                record = _parse(opcode, body)
            except Exception:  # Damage can show in any way.
                continue
            if isinstance(record, Statistics):
                self._promised = record.channel_message_counts
            else:
                self._Define(record)

    def _ReadData(self, data: mmap.mmap) -> Iterator[RawMessage]:
        damaged: Counter[str] = Counter()
        end = len(_MAGIC)
        for opcode, body, end in _records(data, len(_MAGIC)):
            try:
                record = _parse(opcode, body)
                content = _content(record)
            except Exception:  # Damage can show in any way.
                damaged["chunk" if opcode == Opcode.CHUNK else "record"] += 1
                continue
            if isinstance(record, DataEnd):
                begin = end - _RECORD_HEADER.size - len(body)
                self._CheckEnd(data, begin, record)
                break
            yield from self._Select(content)
        else:
            self.damage.append(
                f"the file is cut off: what is whole ends at byte {end} of "
                f"{len(data)}, and was used"
            )
        for noun, count in damaged.items():
            self.damage.append(f"left out {plural(count, noun)}: damaged")

    def _Select(self, records: list[McapRecord]) -> Iterator[RawMessage]:
        for record in records:
            if not isinstance(record, Message):
                self._Define(record)
                continue
            self._found[record.channel_id] += 1
            channel = self._channels.get(record.channel_id)
            if channel is not None and channel.topic in self._topics:
                yield RawMessage(
                    topic=channel.topic,
                    encoding=channel.message_encoding,
                    schema=self._schemas.get(channel.schema_id),
                    log_time=record.log_time,
                    data=record.data,
                )

    def _Define(self, record: McapRecord | None) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels[record.id] = record
            schema = self._schemas.get(record.schema_id)
            self.types[record.topic] = schema.name if schema else ""

    def _CheckEnd(self, data: mmap.mmap, begin: int, record: DataEnd) -> None:
        with memoryview(data) as view, view[:begin] as section:
            crc = zlib.crc32(section)
        if record.data_section_crc not in (0, crc):
            self.damage.append(
                "the checksum of the file is wrong: data in it is damaged"
            )
        if data[-len(_MAGIC) :] != _MAGIC:
            self.damage.append("the file is cut off after its last message")

    def _CompareCounts(self) -> None:
        for identifier, count in self._found.items():
            if identifier not in self._channels:
                self.damage.append(
                    f"left out {plural(count, 'message')}: the file does not "
                    "say on what topic"
                )
        for identifier, promised in self._promised.items():
            channel = self._channels.get(identifier)
            found = self._found[identifier]
            if channel and channel.topic in self._topics and found != promised:
                self.damage.append(
                    f"the file says that {channel.topic} has "
                    f"{plural(promised, 'message')}, but {found} could be read"
                )


def _open(filename: Path) -> mmap.mmap:
    """Returns the file's bytes, without loading them."""
    try:
        with filename.open("rb") as file:
            start = file.read(16)
            if start.startswith(_MAGIC):
                return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except OSError as error:
        raise LogError(f"it can't be opened: {error.strerror}") from error
    found = f"it starts with {start!r}" if start else "it is empty"
    for magic, name in _OTHER_FORMATS.items():
        if start.startswith(magic):
            found = f"it is {name}; convert it first"
    raise LogError(f"expected an MCAP file, but {found}")


def _records(data: mmap.mmap, begin: int) -> Iterator[tuple[int, bytes, int]]:
    """Yields (opcode, content, end) of every whole record from ``begin``."""
    while True:
        header = data[begin : begin + _RECORD_HEADER.size]
        if len(header) < _RECORD_HEADER.size:
            return
        opcode, length = _RECORD_HEADER.unpack(header)
        begin += _RECORD_HEADER.size
        if begin + length > len(data):
            return
        yield opcode, data[begin : begin + length], begin + length
        begin += length


def _parse(opcode: int, body: bytes) -> McapRecord | None:
    stream = ReadDataStream(BytesIO(body))
    if opcode == Opcode.MESSAGE:
        return Message.read(stream, len(body))
    # All other records are of no use here.
    return _PARSERS[opcode](stream) if opcode in _PARSERS else None


def _content(record: McapRecord | None) -> list[McapRecord]:
    """Returns what is in a chunk, whose checksum is checked, or the record."""
    if isinstance(record, Chunk):
        return breakup_chunk(record, validate_crc=True)
    return [record] if record else []


def _summary_start(data: mmap.mmap) -> int | None:
    """Returns where the summary starts, if there is one that is whole."""
    if len(data) < _END.size:
        return None
    start, _, crc, magic = _END.unpack(data[-_END.size :])
    if magic != _MAGIC or not 0 < start < len(data):
        return None
    # The checksum covers all up to itself.
    if crc not in (0, zlib.crc32(data[start : len(data) - 12])):
        return None
    return start
