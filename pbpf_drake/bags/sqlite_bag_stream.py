"""Reads the messages of a ROS 2 SQLite bag (.db3), also of a damaged one.

Messages are rows with consecutive numbers. Where the database can't be read,
reading goes on at the next row that can. The format has no checksums.
"""

from collections.abc import Iterator
from contextlib import closing
import os
from pathlib import Path
import re
import shutil
import sqlite3
import tempfile
from typing import Any
from urllib.parse import quote

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import plural
from pbpf_drake.bags.log_stream import LogStream, RawMessage, Topics

SQLITE_MAGIC = b"SQLite format 3\0"
_ROWS = "SELECT id, topic_id, timestamp, data FROM messages"
# After this many rows on end that can't be read, each step passes over twice as
# many as the one before.
_PATIENCE = 200

# Number, topic, time, data.
_Row = tuple[Any, Any, Any, Any]


class SqliteBagStream(LogStream):
    """The messages of one file; see LogStream."""

    kind = "a ROS 2 SQLite bag"

    def __init__(self, *, filename: Path, topics: Topics = None):
        """Prepares to read a file; see LogStream."""
        super().__init__(filename=filename, topics=topics)
        # By the topic's number: topic, type, encoding, definition.
        self._known: dict[int, tuple[str, str, str, str]] = {}
        self._unknown = 0

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: there is no such file, or it is not a ROS 2 bag.
        """
        with (
            tempfile.TemporaryDirectory() as folder,
            closing(_connect(self._Mended(Path(folder)))) as database,
        ):
            self.checksums = False
            self._ReadTopics(database)
            for row in self._Rows(database):
                yield from self._Select(row)
        self._SayWhatWasDamaged()
        if self._unknown:
            count = plural(self._unknown, "message")
            self.damage.append(f"left out {count} of an unknown topic")
        if self.damage:
            self._SayThatNumbersMayBeWrong()

    def _Mended(self, folder: Path) -> Path:
        """Returns the file, or a copy of it that ends with a whole page.

        Where a page is cut off, SQLite would read zeros.
        """
        path = self._filename.absolute()
        size = path.stat().st_size
        with path.open("rb") as file:
            header = file.read(32)
        page = int.from_bytes(header[16:18], "big")
        page = 65536 if page == 1 else page
        expected = page * int.from_bytes(header[28:32], "big")
        if size < expected:
            self.damage.append(
                f"the file is cut off: it has {size} of {expected} bytes"
            )
        if not page or size % page == 0:
            return path
        copy = folder / path.name
        shutil.copyfile(path, copy)
        os.truncate(copy, size - size % page)
        return copy

    def _ReadTopics(self, database: sqlite3.Connection) -> None:
        try:
            definitions = self._Definitions(database)
            rows = database.execute(
                "SELECT id, name, type, serialization_format FROM topics"
            ).fetchall()
        except sqlite3.Error as error:
            raise LogError(
                f"it is an SQLite file without the topics of a ROS 2 bag, or "
                f"they are damaged ({error})"
            ) from error
        for number, topic, kind, encoding in rows:
            if not _is_name(topic) or not _is_name(kind):
                self.damage.append(f"left out the topic {topic!r}: damaged")
                continue
            text = definitions.get(kind, "")
            self._known[number] = topic, kind, str(encoding), text
            self.types[topic] = kind

    def _Definitions(self, database: sqlite3.Connection) -> dict[str, str]:
        """Returns the definitions of types, which older bags don't have."""
        if not _columns(database, "message_definitions"):
            return {}
        try:
            rows = database.execute(
                "SELECT topic_type, encoding, encoded_message_definition "
                "FROM message_definitions"
            ).fetchall()
        except sqlite3.Error as error:
            self.damage.append(f"definitions of types are damaged ({error})")
            return {}
        return {
            kind: text
            for kind, encoding, text in rows
            if encoding == "ros2msg" and isinstance(text, str)
        }

    def _Rows(self, database: sqlite3.Connection) -> Iterator[_Row]:
        """Yields the rows in order, and passes over those that are damaged."""
        query = f"{_ROWS} WHERE id > ? ORDER BY id"
        last = _last_number(database)
        # The number of the last row that was good, and the number after which
        # to try next.
        good = number = -1
        failures, reason = 0, ""
        while number < last:
            try:
                for row in database.execute(query, (number,)):
                    if failures:
                        self._SayLost(f"{good + 1} to {row[0] - 1}", reason)
                    failures, good = 0, row[0]
                    number = good
                    yield row
                break
            except sqlite3.Error as error:
                failures, reason = failures + 1, str(error)
                number += 2 ** max(0, failures - _PATIENCE)
        if failures:
            self._SayLost(f"after {good}", reason)

    def _SayLost(self, numbers: str, reason: str) -> None:
        self.damage.append(f"left out the messages {numbers}: {reason}")

    def _Select(self, row: _Row) -> Iterator[RawMessage]:
        _, number, time, data = row
        known = self._known.get(number)
        if not isinstance(time, int) or not isinstance(data, bytes):
            self._damaged["message"] += 1
        elif known is None:
            self._unknown += 1
        elif self._IsWanted(known[0]):
            topic, kind, encoding, text = known
            yield RawMessage(topic, kind, encoding, text, time, data)


def _connect(path: Path) -> sqlite3.Connection:
    # Without a journal beside it nothing else writes to the file.
    journal = path.with_name(path.name + "-wal")
    mode = "mode=ro" if journal.exists() else "mode=ro&immutable=1"
    database = sqlite3.connect(f"file:{quote(str(path))}?{mode}", uri=True)
    database.text_factory = lambda text: text.decode(errors="replace")
    # Otherwise SQLite refuses a file whose end is missing.
    database.execute("PRAGMA writable_schema = ON")
    return database


def _is_name(text: Any) -> bool:
    """Tells if a topic or a type can have this name."""
    return isinstance(text, str) and bool(re.fullmatch(r"[\w/~]+", text, re.A))


def _columns(database: sqlite3.Connection, table: str) -> list[str]:
    rows = database.execute(f"PRAGMA table_info({table})").fetchall()
    return [row[1] for row in rows]


def _last_number(database: sqlite3.Connection) -> int:
    """Returns the number of the last message, as far as that is known."""
    try:
        (last,) = database.execute("SELECT max(id) FROM messages").fetchone()
    except sqlite3.Error:
        return 2**62
    return last or 0
