"""Reads the messages of a ROS 1 bag, also of one that is damaged.

The file is walked record by record. Its index is only used to find the next
record after damage, for a recording that was broken off has none. A chunk that
can't be unpacked is left out and the next one is read. A chunk is followed by
an index of its messages: ``damage`` says where the two differ. Only chunks that
are compressed have checksums.
"""

from collections.abc import Iterator
import mmap
from pathlib import Path

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import plural
from pbpf_drake.bags.log_stream import (
    LogStream,
    OpenBytes,
    RawMessage,
    Topics,
)
from pbpf_drake.bags.ros1_decoding import definition_matches
from pbpf_drake.bags.ros1_records import (
    BAG_MAGIC,
    CHUNK,
    CHUNK_INFO,
    CONNECTION,
    HEADER,
    INDEX,
    MESSAGE,
    Record,
    has_checksum,
    index_entries,
    parse_fields,
    unpack_chunk,
    walk_records,
)


class Ros1BagStream(LogStream):
    """The messages of one file; see LogStream."""

    kind = "a ROS 1 bag"

    def __init__(self, *, filename: Path, topics: Topics = None):
        """Prepares to read a file; see LogStream."""
        super().__init__(filename=filename, topics=topics)
        # By the connection's number: topic, type, definition.
        self._connections: dict[int, tuple[str, str, str]] = {}
        # The connections whose definition has the right checksum.
        self._checked: set[int] = set()
        self._unprotected = False
        self._promised_chunks = 0

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: there is no such file, it can't be opened, or it is
                encrypted.
        """
        with OpenBytes(self._filename) as data:
            missing = self._ReadIndex(data)
            for record in self._Walk(data, sorted(missing)):
                missing.discard(record.begin if record.kind == CHUNK else -1)
                if record.kind == CHUNK:
                    yield from self._ReadChunk(record, data)
                else:
                    yield from self._Select(record)
        if missing:
            self.damage.append(
                f"{plural(len(missing), 'chunk')} can't be found where the "
                "file's index says"
            )
        self._SayWhatWasDamaged()
        self.checksums = not self._unprotected
        if self.damage and self._unprotected:
            self._SayThatNumbersMayBeWrong()

    def _ReadIndex(self, data: mmap.mmap) -> set[int]:
        """Reads the index, and returns where chunks start."""
        place = self._IndexPlace(data)
        if not len(BAG_MAGIC) < place <= len(data):
            self.damage.append(
                "the file has no index: its recording was broken off, or its "
                "end is missing"
            )
            return set()
        chunks = set()
        for record in _whole_records(data, place):
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

    def _IndexPlace(self, data: mmap.mmap) -> int:
        header = next(_whole_records(data, len(BAG_MAGIC)), None)
        if header is None or header.kind != HEADER:
            return -1
        encryptor = header.fields.get("encryptor")
        if encryptor:
            raise LogError(f"it is encrypted, by {encryptor!r}")
        self._promised_chunks = header.Number("chunk_count")
        return header.Number("index_pos")

    def _Walk(self, data: mmap.mmap, chunks: list[int]) -> Iterator[Record]:
        def lost(begin: int, end: int) -> None:
            if end < len(data):
                self.damage.append(f"left out bytes {begin} to {end}: damaged")
            else:
                self._SayThatItIsCutOff(begin, end)

        return walk_records(
            data, begin=len(BAG_MAGIC), end=len(data), starts=chunks, lost=lost
        )

    def _ReadChunk(
        self, chunk: Record, data: mmap.mmap
    ) -> Iterator[RawMessage]:
        try:
            content = unpack_chunk(chunk)
        except Exception:  # Damage can show in any way.
            self._damaged["chunk"] += 1
            return
        self._unprotected |= not has_checksum(chunk)

        def lost(begin: int, end: int) -> None:
            self._damaged["part of a chunk"] += 1

        index = dict(_index_after(data, chunk.end))
        found = set()
        for record in walk_records(
            content,
            begin=0,
            end=len(content),
            starts=sorted(index),
            lost=lost,
        ):
            if record.kind == MESSAGE:
                found.add(record.begin)
                entry = record.Number("conn"), record.Time()
                if index.get(record.begin, entry) != entry:
                    self._damaged["message unlike its index"] += 1
                    continue
            yield from self._Select(record)
        count = len(found ^ set(index))
        if count:
            self.damage.append(
                f"{plural(count, 'message')} of a chunk can't be found, or "
                "are not in its index"
            )

    def _Select(self, record: Record) -> Iterator[RawMessage]:
        if record.kind == CONNECTION:
            self._Define(record)
        elif record.kind == MESSAGE:
            known = self._connections.get(record.Number("conn"))
            if known is None:
                self._damaged["message of an unknown topic"] += 1
            elif self._IsWanted(known[0]):
                topic, kind, text = known
                yield RawMessage(
                    topic, kind, "ros1", text, record.Time(), record.data
                )

    def _Define(self, record: Record) -> None:
        identifier = record.Number("conn")
        if identifier in self._checked:
            return
        try:
            fields = parse_fields(record.data)
            topic = record.fields["topic"].decode()
            kind, checksum, text = (
                fields[name].decode(errors="replace")
                for name in ("type", "md5sum", "message_definition")
            )
        except (KeyError, ValueError):
            self._damaged["description of a topic"] += 1
            return
        if self._IsWanted(topic) and not definition_matches(
            kind, text, checksum
        ):
            text = ""
        else:
            self._checked.add(identifier)
        self._connections[identifier] = topic, kind, text
        self.types[topic] = kind


def _whole_records(data: mmap.mmap, begin: int) -> Iterator[Record]:
    """Yields records up to the first that is damaged."""
    return walk_records(
        data,
        begin=begin,
        end=len(data),
        starts=(),
        lost=lambda begin, end: None,
    )


def _index_after(
    data: mmap.mmap, begin: int
) -> Iterator[tuple[int, tuple[int, int]]]:
    """Yields what the index behind a chunk says of its messages.

    Yields:
        A message's offset in the chunk, and the number of its connection with
        its time (in nanoseconds).
    """
    for record in _whole_records(data, begin):
        if record.kind != INDEX:
            return
        for connection, time, offset in index_entries(record):
            yield offset, (connection, time)
