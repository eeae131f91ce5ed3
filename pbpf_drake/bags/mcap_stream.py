"""Reads the messages of an MCAP file, also of one that is damaged.

A file is walked record by record. Every chunk of messages carries a checksum:
a chunk that fails it is left out and the next one is read. A file that was cut
off is used up to the last message that is whole. The file's own count of
messages tells what is missing. Nothing is left out without a sentence in
``damage``.
"""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
import zlib

from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    ChunkIndex,
    DataEnd,
    McapRecord,
    Schema,
    Statistics,
)

from pbpf_drake.bags.log_notes import plural
from pbpf_drake.bags.log_stream import (
    LogStream,
    OpenBytes,
    RawMessage,
    Topics,
)
from pbpf_drake.bags.mcap_records import (
    MCAP_MAGIC,
    RECORD_HEADER,
    McapChunk,
    McapMessage,
    Place,
    check_records,
    cut_chunk,
    find_summary,
    parse_chunk,
    parse_message,
    parse_record,
    walk_records,
)
from pbpf_drake.bags.read_budget import BudgetSpent
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, LimitError, ReadLimits
from pbpf_drake.bags.type_guess import TypeGuess

# What this project can decode.
_ENCODINGS = ("cdr", "ros1")


class McapStream(LogStream):
    """The messages of one file; see LogStream."""

    kind = "an MCAP file"

    def __init__(
        self,
        *,
        filename: Path,
        topics: Topics = None,
        limits: ReadLimits = DEFAULT_LIMITS,
    ):
        """Prepares to read a file; see LogStream."""
        super().__init__(filename=filename, topics=topics, limits=limits)
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        # By channel, how many messages there should be, and how many there are.
        self._promised: dict[int, int] = {}
        self._found: Counter[int] = Counter()
        # Where chunks start.
        self._chunks: set[int] = set()
        # The topics with messages of ROS.
        self._readable: set[str] = set()
        # By topic, what type its messages seem to be.
        self._guesses: dict[str, TypeGuess] = {}
        # Whether the records at hand were covered by a checksum.
        self._protected = False

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: there is no such file, or it can't be opened.
        """
        # It is closed once no part of it is in use.
        data = memoryview(OpenBytes(self._filename))
        try:
            self._ReadSummary(data)
            yield from self._ReadData(data)
        except BudgetSpent as error:
            self._SayThatItEndsHere(error)
        self._SayWhatWasLeftOut()
        self._CompareCounts()
        self._SayIfNumbersMayBeWrong()
        for topic, guess in self._guesses.items():
            if guess.type:
                self.types[topic] = guess.type
                self.damage.append(f"{topic}: {guess.Sentence()}")

    def _ReadSummary(self, data: memoryview) -> None:
        # It repeats schemas and channels, whose first copies may be damaged.
        start = find_summary(data)
        if start is None:
            return
        for place in walk_records(data, start):
            self._budget.CountRecord()
            try:
                record = parse_record(
                    place.opcode, data[place.begin : place.end]
                )
            except Exception:  # Damage can show in any way.
                continue
            if isinstance(record, Statistics):
                self._promised = record.channel_message_counts
            elif isinstance(record, ChunkIndex):
                self._chunks.add(record.chunk_start_offset)
            else:
                self._Define(record)

    def _ReadData(self, data: memoryview) -> Iterator[RawMessage]:
        end = len(MCAP_MAGIC)
        for place in walk_records(data, end, sorted(self._chunks)):
            end = place.end
            self._budget.CountRecord()
            content = data[place.begin : end]
            if place.opcode == Opcode.DATA_END and self._IsEnd(data, place):
                break
            if place.opcode == Opcode.CHUNK:
                yield from self._ReadChunk(content)
            else:
                yield from self._ReadRecord(place.opcode, content)
        else:
            self._SayThatItIsCutOff(end, len(data))
            chunk = cut_chunk(data, end)
            if chunk is not None:
                yield from self._ReadCutChunk(chunk)

    def _IsEnd(self, data: memoryview, place: Place) -> bool:
        """Tells if the data ends here, and checks all of it."""
        try:
            record = parse_record(place.opcode, data[place.begin : place.end])
        except Exception:  # Damage can show in any way.
            self._LeaveOut("record")
            return False
        assert isinstance(record, DataEnd)
        expected = record.data_section_crc
        self.checksums |= expected != 0
        section = data[: place.begin - RECORD_HEADER.size]
        if expected not in (0, zlib.crc32(section)):
            self.damage.append(
                "the checksum of the file is wrong: data in it is damaged"
            )
        if data[-len(MCAP_MAGIC) :] != MCAP_MAGIC:
            self.damage.append("the file is cut off after its last message")
        return True

    def _ReadChunk(self, content: memoryview) -> Iterator[RawMessage]:
        try:
            chunk = parse_chunk(content)
            records = self._budget.Unpack(chunk.compression, chunk.packed)
            check_records(chunk, records.content)
        except BudgetSpent:
            raise
        except LimitError as error:
            self._LeaveOut("chunk", f": {error}")
        except Exception:  # Damage can show in any way.
            self._LeaveOut("chunk")
        else:
            self._protected = chunk.crc != 0
            yield from self._ReadRecords(memoryview(records.content))

    def _ReadCutChunk(self, chunk: McapChunk) -> Iterator[RawMessage]:
        """Reads what is left of a chunk whose end is not in the file."""
        before = self._found.total()
        try:
            records = self._budget.Unpack(chunk.compression, chunk.packed)
        except Exception:  # That it is cut off is said already.
            return
        self._protected = True
        yield from self._ReadRecords(memoryview(records.content), cut=True)
        self._SayWhatIsLeftOfAChunk(self._found.total() - before)

    def _ReadRecords(
        self, records: memoryview, *, cut: bool = False
    ) -> Iterator[RawMessage]:
        end = 0
        for place in walk_records(records, 0):
            end = place.end
            self._budget.CountRecord()
            content = records[place.begin : end]
            yield from self._ReadRecord(place.opcode, content)
        if end != len(records) and not cut:
            self._LeaveOut("part of a chunk")
        self._protected = False

    def _ReadRecord(
        self, opcode: int, content: memoryview
    ) -> Iterator[RawMessage]:
        try:
            if opcode != Opcode.MESSAGE:
                self._Define(parse_record(opcode, content))
                return
            message = parse_message(content)
        except Exception:  # Damage can show in any way.
            self._LeaveOut("record")
            return
        yield from self._Select(message)

    def _Select(self, message: McapMessage) -> Iterator[RawMessage]:
        self._found[message.channel_id] += 1
        self.checksums &= self._protected
        channel = self._channels.get(message.channel_id)
        if not self._IsAdmitted(len(message.data)) or channel is None:
            return
        topic, encoding = channel.topic, channel.message_encoding
        if not self._IsWanted(topic):
            return
        if topic in self._readable and encoding not in _ENCODINGS:
            self._LeaveOut(
                "message",
                f" of {topic} encoded as {encoding!r}, beside those of ROS",
            )
            return
        yield self._MakeMessage(message, channel)

    def _MakeMessage(
        self, message: McapMessage, channel: Channel
    ) -> RawMessage:
        schema = self._schemas.get(channel.schema_id)
        data = bytes(message.data)
        kind = schema.name if schema else ""
        if not kind and channel.message_encoding == "cdr":
            guess = self._guesses.setdefault(
                channel.topic, TypeGuess(self._limits)
            )
            kind = guess.Look(data)
        return RawMessage(
            topic=channel.topic,
            type=kind,
            encoding=channel.message_encoding,
            definition=_definition(schema) if schema else "",
            log_time=message.log_time,
            data=data,
        )

    def _Define(self, record: McapRecord | None) -> None:
        if isinstance(record, Schema):
            self._schemas[record.id] = record
        elif isinstance(record, Channel):
            self._channels[record.id] = record
            readable = record.message_encoding in _ENCODINGS
            schema = self._schemas.get(record.schema_id)
            if readable or record.topic not in self._readable:
                self.types[record.topic] = schema.name if schema else ""
            if readable:
                self._readable.add(record.topic)

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
