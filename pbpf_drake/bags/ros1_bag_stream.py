"""Reads the messages of a ROS 1 bag, also of one that is damaged.

The file is walked record by record. Its index is only used to find the next
record after damage, for a recording that was broken off has none. A chunk that
can't be unpacked is left out and the next one is read. A chunk is followed by
an index of its messages: ``damage`` says where the two differ. Only chunks that
are compressed have checksums.
"""

from collections.abc import Iterator
from pathlib import Path

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import plural
from pbpf_drake.bags.log_stream import (
    LogStream,
    OpenBytes,
    RawMessage,
    Topics,
)
from pbpf_drake.bags.message_types import definition_matches
from pbpf_drake.bags.read_budget import BudgetSpent
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, LimitError, ReadLimits
from pbpf_drake.bags.ros1_records import (
    BAG_MAGIC,
    CHUNK,
    CHUNK_INFO,
    CONNECTION,
    HEADER,
    MESSAGE,
    Record,
    cut_chunk,
    has_checksum,
    index_after,
    parse_fields,
    walk_records,
    whole_records,
)


class Ros1BagStream(LogStream):
    """The messages of one file; see LogStream."""

    kind = "a ROS 1 bag"

    def __init__(
        self,
        *,
        filename: Path,
        topics: Topics = None,
        limits: ReadLimits = DEFAULT_LIMITS,
    ):
        """Prepares to read a file; see LogStream."""
        super().__init__(filename=filename, topics=topics, limits=limits)
        # By the connection's number: topic, type, definition.
        self._connections: dict[int, tuple[str, str, str]] = {}
        # The connections whose definition has the right checksum.
        self._checked: set[int] = set()
        # The definitions that were checked, and how much more is.
        self._definitions: set[str] = set()
        self._left_definitions = limits.definitions
        self._promised_chunks = 0

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: there is no such file, it can't be opened, or it is
                encrypted.
        """
        # It is closed once no part of it is in use.
        data = memoryview(OpenBytes(self._filename))
        missing: set[int] = set()
        try:
            missing = self._ReadIndex(data)
            yield from self._ReadAll(data, missing)
        except BudgetSpent as error:
            self._SayThatItEndsHere(error)
            missing = set()
        if missing:
            self.damage.append(
                f"{plural(len(missing), 'chunk')} can't be found where the "
                "file's index says"
            )
        self._SayWhatWasLeftOut()
        self._SayIfNumbersMayBeWrong()

    def _ReadIndex(self, data: memoryview) -> set[int]:
        """Reads the index, and returns where chunks start."""
        place = self._IndexPlace(data)
        if not len(BAG_MAGIC) < place <= len(data):
            self.damage.append(
                "the file has no index: its recording was broken off, or its "
                "end is missing"
            )
            return set()
        chunks = set()
        for record in whole_records(data, place):
            self._budget.CountRecord()
            # It repeats connections, whose first copies may be damaged.
            if record.kind == CONNECTION:
                self._Define(record)
            elif record.kind == CHUNK_INFO:
                chunks.add(record.Number("chunk_pos"))
        if len(chunks) != self._promised_chunks:
            self.damage.append(
                f"the file's index names {plural(len(chunks), 'chunk')}, but "
                f"the file says that it has {self._promised_chunks}"
            )
        return chunks

    def _IndexPlace(self, data: memoryview) -> int:
        header = next(whole_records(data, len(BAG_MAGIC)), None)
        if header is None or header.kind != HEADER:
            return -1
        encryptor = header.fields.get("encryptor")
        if encryptor:
            raise LogError(f"it is encrypted, by {encryptor!r}")
        self._promised_chunks = header.Number("chunk_count")
        return header.Number("index_pos")

    def _ReadAll(
        self, data: memoryview, missing: set[int]
    ) -> Iterator[RawMessage]:
        """Reads the file, and takes what it finds out of ``missing``."""
        # Where what is whole ends.
        end = len(data)

        def lost(begin: int, behind: int) -> None:
            nonlocal end
            if behind < len(data):
                self._Say(f"left out bytes {begin} to {behind}: damaged")
            else:
                end = begin

        for record in walk_records(
            data,
            begin=len(BAG_MAGIC),
            end=len(data),
            starts=sorted(missing),
            lost=lost,
        ):
            self._budget.CountRecord()
            missing.discard(record.begin if record.kind == CHUNK else -1)
            if record.kind == CHUNK:
                yield from self._ReadChunk(record, data)
            else:
                self.checksums &= record.kind != MESSAGE
                yield from self._Select(record)
        if end < len(data):
            self._SayThatItIsCutOff(end, len(data))
            yield from self._ReadCutChunk(data, end)

    def _ReadCutChunk(
        self, data: memoryview, begin: int
    ) -> Iterator[RawMessage]:
        """Reads what is left of a chunk whose end is not in the file."""
        chunk = cut_chunk(data, begin)
        if chunk is None:
            return
        try:
            found = self._budget.Unpack(chunk.Text("compression"), chunk.data)
        except Exception:  # That it is cut off is said already.
            return
        content = memoryview(found.content)
        count = 0
        for record in whole_records(content, 0):
            self._budget.CountRecord()
            count += record.kind == MESSAGE
            yield from self._Select(record)
        self._SayWhatIsLeftOfAChunk(count)

    def _ReadChunk(
        self, chunk: Record, data: memoryview
    ) -> Iterator[RawMessage]:
        try:
            found = self._budget.Unpack(chunk.Text("compression"), chunk.data)
            content = memoryview(found.content)
            if not found.whole or len(content) != chunk.Number("size"):
                raise ValueError("its size is wrong")
        except BudgetSpent:
            raise
        except LimitError as error:
            self._LeaveOut("chunk", f": {error}")
            return
        except Exception:  # Damage can show in any way.
            self._LeaveOut("chunk")
            return
        self.checksums &= has_checksum(chunk)
        index = {}
        for offset, entry in index_after(data, chunk.end):
            self._budget.CountRecord()
            index[offset] = entry
        yield from self._ReadContent(content, index)

    def _ReadContent(
        self, content: memoryview, index: dict[int, tuple[int, int]]
    ) -> Iterator[RawMessage]:
        """Reads what is in a chunk.

        Args:
            content: unpacked.
            index: see index_after.
        """

        def lost(begin: int, end: int) -> None:
            self._LeaveOut("part of a chunk")

        found = set()
        for record in walk_records(
            content,
            begin=0,
            end=len(content),
            starts=sorted(index),
            lost=lost,
        ):
            self._budget.CountRecord()
            if record.kind == MESSAGE:
                found.add(record.begin)
                entry = record.Number("conn"), record.Time()
                if index.get(record.begin, entry) != entry:
                    self._LeaveOut("message", " unlike its index: damaged")
                    continue
            yield from self._Select(record)
        count = len(found ^ set(index))
        if count:
            self._Say(
                f"{plural(count, 'message')} of a chunk can't be found, or "
                "are not in its index"
            )

    def _Select(self, record: Record) -> Iterator[RawMessage]:
        if record.kind == CONNECTION:
            self._Define(record)
        elif record.kind == MESSAGE:
            known = self._connections.get(record.Number("conn"))
            if not self._IsAdmitted(len(record.data)):
                return
            if known is None:
                self._LeaveOut("message", " of an unknown topic")
            elif self._IsWanted(known[0]):
                topic, kind, text = known
                yield RawMessage(
                    topic,
                    kind,
                    "ros1",
                    text,
                    record.Time(),
                    bytes(record.data),
                )

    def _Define(self, record: Record) -> None:
        identifier = record.Number("conn")
        if identifier in self._checked:
            return
        try:
            fields = parse_fields(bytes(record.data))
            topic = record.fields["topic"].decode()
            kind, checksum, text = (
                fields[name].decode(errors="replace")
                for name in ("type", "md5sum", "message_definition")
            )
        except (KeyError, ValueError):
            self._LeaveOut("description of a topic")
            return
        if self._IsWanted(topic) and not self._Matches(kind, text, checksum):
            text = ""
        else:
            self._checked.add(identifier)
        self._connections[identifier] = topic, kind, text
        self.types[topic] = kind

    def _Matches(self, kind: str, text: str, checksum: str) -> bool:
        if text not in self._definitions:
            self._definitions.add(text)
            self._left_definitions -= len(text)
        return self._left_definitions >= 0 and definition_matches(
            kind, text, checksum, self._limits
        )
