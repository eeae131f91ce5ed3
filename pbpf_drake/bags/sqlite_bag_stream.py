"""Reads the messages of a ROS 2 SQLite bag (.db3), also of a damaged one.

Messages are rows with consecutive numbers. Where the database can't be read,
reading goes on at the next row that can. The format has no checksums.
"""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
import re
import sqlite3
import tempfile
from typing import Any

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_stream import (
    LogStream,
    RawMessage,
    Topics,
)
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, ReadLimits
from pbpf_drake.bags.sqlite_database import (
    Row,
    RowsEndError,
    SqliteDatabase,
    whole_pages,
)

SQLITE_MAGIC = b"SQLite format 3\0"
_ROWS = (
    "SELECT id, topic_id, timestamp, data FROM messages WHERE id > ? "
    "ORDER BY id"
)
# After this many rows on end that can't be read, each step passes over twice as
# many as the one before; and so it does from the start after many such places.
_PATIENCE, _MANY = 200, 2000


class SqliteBagStream(LogStream):
    """The messages of one file; see LogStream."""

    kind = "a ROS 2 SQLite bag"

    def __init__(
        self,
        *,
        filename: Path,
        topics: Topics = None,
        limits: ReadLimits = DEFAULT_LIMITS,
    ):
        """Prepares to read a file; see LogStream."""
        super().__init__(filename=filename, topics=topics, limits=limits)
        self.checksums = False
        # By the topic's number: topic, type, encoding, definition.
        self._known: dict[int, tuple[str, str, str, str]] = {}

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: there is no such file, or it is not a ROS 2 bag.
        """
        with tempfile.TemporaryDirectory() as folder:
            path, said = whole_pages(self._filename, Path(folder))
            self.damage += [said] if said else []
            size = self.size + _journal_size(path)
            with closing(SqliteDatabase(path, self._limits, size)) as database:
                self._ReadTopics(database)
                try:
                    for row in self._Rows(database):
                        yield from self._Select(row)
                except RowsEndError as error:
                    self._SayThatItEndsHere(error)
        self._SayWhatWasLeftOut()
        self._SayIfNumbersMayBeWrong()

    def _ReadTopics(self, database: SqliteDatabase) -> None:
        try:
            if not database.HasTable("topics") or not database.HasTable(
                "messages"
            ):
                raise sqlite3.DatabaseError("no such table")
            definitions = self._Definitions(database)
            rows = list(
                database.Rows(
                    "SELECT id, name, type, serialization_format FROM topics"
                )
            )
        except (sqlite3.Error, RowsEndError) as error:
            raise LogError(
                f"it is an SQLite file without the topics of a ROS 2 bag, or "
                f"they are damaged ({error})"
            ) from error
        for number, topic, kind, encoding in rows:
            if not _is_name(topic) or not _is_name(kind):
                self._Say(f"left out the topic {topic!r}: damaged")
                continue
            text = definitions.get(kind, "")
            self._known[number] = topic, kind, str(encoding), text
            self.types[topic] = kind

    def _Definitions(self, database: SqliteDatabase) -> dict[str, str]:
        """Returns the definitions of types, which older bags don't have."""
        try:
            if not database.HasTable("message_definitions"):
                return {}
            rows = list(
                database.Rows(
                    "SELECT topic_type, encoding, encoded_message_definition "
                    "FROM message_definitions"
                )
            )
        except (sqlite3.Error, RowsEndError) as error:
            self.damage.append(f"definitions of types are damaged ({error})")
            return {}
        return {
            kind: text
            for kind, encoding, text in rows
            if encoding == "ros2msg" and isinstance(text, str)
        }

    def _Rows(self, database: SqliteDatabase) -> Iterator[Row]:
        """Yields the rows in order, and passes over those that are damaged."""
        last = _last_number(database)
        # The number of the last row that was good, and the number after which
        # to try next.
        good = number = -1
        failures, places, reason = 0, 0, ""
        while number < last:
            try:
                for row in database.Rows(_ROWS, (number,)):
                    _check_number(row[0], good, last)
                    if failures:
                        numbers = f"{good + 1} to {row[0] - 1}"
                        self._SayLost(numbers, reason)
                    failures, good = 0, row[0]
                    number = good
                    yield row
                break
            except (sqlite3.Error, _OutOfOrderError) as error:
                failures, places = failures + 1, places + 1
                reason = str(error)
                patience = _PATIENCE if places < _MANY else 0
                number += 2 ** max(0, failures - patience)
        if failures:
            self._SayLost(f"after {good}", reason)

    def _SayLost(self, numbers: str, reason: str) -> None:
        self._Say(f"left out the messages {numbers}: {reason}")

    def _Select(self, row: Row) -> Iterator[RawMessage]:
        _, number, time, data = row
        if not isinstance(time, int) or not isinstance(data, bytes):
            self._LeaveOut("message")
            return
        known = self._known.get(number)
        if known is None:
            self._LeaveOut("message", " of an unknown topic")
        elif self._IsWanted(known[0]):
            topic, kind, encoding, text = known
            yield RawMessage(topic, kind, encoding, text, time, data)


class _OutOfOrderError(ValueError):
    """A row is not where it should be."""


def _check_number(number: Any, after: int, last: int) -> None:
    """Checks the number of a row.

    Args:
        number: what the file has in its place.
        after: the number of the row before.
        last: the number of the last row.

    Raises:
        _OutOfOrderError: it can't follow.
    """
    if not isinstance(number, int) or not after < number <= last:
        raise _OutOfOrderError(f"row {number} can't follow row {after}")


def _is_name(text: Any) -> bool:
    """Tells if a topic or a type can have this name."""
    return isinstance(text, str) and bool(re.fullmatch(r"[\w/~]+", text, re.A))


def _journal_size(path: Path) -> int:
    journal = path.with_name(path.name + "-wal")
    return journal.stat().st_size if journal.exists() else 0


def _last_number(database: SqliteDatabase) -> int:
    """Returns the number of the last message, as far as that is known."""
    try:
        ((last,),) = database.Rows("SELECT max(id) FROM messages")
    except sqlite3.Error:
        return 2**62
    return last if isinstance(last, int) else 0
