"""Reads the messages of an MCAP file, also of one that is damaged.

A file is walked record by record. Every chunk of messages carries a checksum:
a chunk that fails it is left out and the next one is read. A file that was cut
off is used up to there. The file's own count of messages tells what is
missing. Nothing is left out without a sentence in ``damage``.
"""

from bisect import bisect_right
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
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
    ChunkIndex,
    DataEnd,
    McapRecord,
    Message,
    Schema,
    Statistics,
)
from mcap.stream_reader import breakup_chunk

from pbpf_drake.bags.log_notes import plural
from pbpf_drake.bags.log_stream import (
    LogStream,
    OpenBytes,
    RawMessage,
    Topics,
)

MCAP_MAGIC = b"\x89MCAP0\r\n"
_RECORD_HEADER = struct.Struct("<BQ")
# The end of a file: the fields of the footer, and the magic.
_END = struct.Struct("<QQI8s")
_PARSERS: dict[int, Callable[[ReadDataStream], McapRecord]] = {
    Opcode.CHANNEL: Channel.read,
    Opcode.CHUNK: Chunk.read,
    Opcode.CHUNK_INDEX: ChunkIndex.read,
    Opcode.DATA_END: DataEnd.read,
    Opcode.SCHEMA: Schema.read,
    Opcode.STATISTICS: Statistics.read,
}


class McapStream(LogStream):
    """The messages of one file; see LogStream."""

    kind = "an MCAP file"

    def __init__(self, *, filename: Path, topics: Topics = None):
        """Prepares to read a file; see LogStream."""
        super().__init__(filename=filename, topics=topics)
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        # By channel, how many messages there should be, and how many there are.
        self._promised: dict[int, int] = {}
        self._found: Counter[int] = Counter()
        # Where chunks start.
        self._chunks: set[int] = set()

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: there is no such file, or it can't be opened.
        """
        with OpenBytes(self._filename) as data:
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
            elif isinstance(record, ChunkIndex):
                self._chunks.add(record.chunk_start_offset)
            else:
                self._Define(record)

    def _ReadData(self, data: mmap.mmap) -> Iterator[RawMessage]:
        begin = end = len(MCAP_MAGIC)
        for opcode, body, end in _records(data, begin, sorted(self._chunks)):
            try:
                record = _parse(opcode, body)
                content = _content(record)
            except Exception:  # Damage can show in any way.
                noun = "chunk" if opcode == Opcode.CHUNK else "record"
                self._damaged[noun] += 1
                continue
            if isinstance(record, DataEnd):
                begin = end - _RECORD_HEADER.size - len(body)
                self._CheckEnd(data, begin, record)
                break
            yield from self._Select(content)
        else:
            self._SayThatItIsCutOff(end, len(data))
        self._SayWhatWasDamaged()

    def _Select(self, records: list[McapRecord]) -> Iterator[RawMessage]:
        for record in records:
            if not isinstance(record, Message):
                self._Define(record)
                continue
            self._found[record.channel_id] += 1
            channel = self._channels.get(record.channel_id)
            if channel is not None and self._IsWanted(channel.topic):
                yield self._MakeMessage(record, channel)

    def _MakeMessage(self, record: Message, channel: Channel) -> RawMessage:
        schema = self._schemas.get(channel.schema_id)
        return RawMessage(
            topic=channel.topic,
            type=schema.name if schema else "",
            encoding=channel.message_encoding,
            definition=_definition(schema) if schema else "",
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
        if data[-len(MCAP_MAGIC) :] != MCAP_MAGIC:
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
            if channel and self._IsWanted(channel.topic):
                found = self._found[identifier]
                self._CompareCount("the file", channel.topic, promised, found)


def _definition(schema: Schema) -> str:
    # A definition in another language, such as IDL, is of no use here.
    if schema.encoding not in ("ros2msg", "ros1msg"):
        return ""
    return schema.data.decode(errors="replace")


def _records(
    data: mmap.mmap, begin: int, chunks: Sequence[int] = ()
) -> Iterator[tuple[int, bytes, int]]:
    """Yields (opcode, content, end) of every whole record from ``begin``.

    After damage it goes on at the next of the places where chunks are known
    to start; otherwise it ends there.
    """
    while True:
        end = _record_end(data, begin)
        resume = _next_chunk(data, begin, end or len(data), chunks)
        if resume is not None:
            # What is passed over shows when messages are counted.
            begin = resume
        elif end is None:
            return
        else:
            yield data[begin], data[begin + _RECORD_HEADER.size : end], end
            begin = end


def _record_end(data: mmap.mmap, begin: int) -> int | None:
    """Returns where the record at one place ends, if it is whole."""
    header = data[begin : begin + _RECORD_HEADER.size]
    if len(header) < _RECORD_HEADER.size:
        return None
    _, length = _RECORD_HEADER.unpack(header)
    end = begin + _RECORD_HEADER.size + length
    return end if end <= len(data) else None


def _next_chunk(
    data: mmap.mmap, begin: int, end: int, chunks: Sequence[int]
) -> int | None:
    """Returns the first known start strictly between with a chunk there."""
    for chunk in chunks[bisect_right(chunks, begin) :]:
        if chunk >= end:
            break
        if data[chunk] == Opcode.CHUNK and _record_end(data, chunk):
            return chunk
    return None


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
    if magic != MCAP_MAGIC or not 0 < start < len(data):
        return None
    # The checksum covers all up to itself.
    if crc not in (0, zlib.crc32(data[start : len(data) - 12])):
        return None
    return start
