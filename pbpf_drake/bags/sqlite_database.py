"""Reads rows of an SQLite file that may be damaged, or made to do harm.

A database can hold programs: views and columns that are worked out, of any
length and without end. And where it is damaged, its rows may lead in a circle.
So rows are of tables only, no more comes out than the file has bytes, and no
query runs for ever.
"""

from collections.abc import Iterator
import os
from pathlib import Path
import re
import shutil
import sqlite3
import time
from typing import Any
from urllib.parse import quote

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.read_limits import ReadLimits

# A row has a header, and values. Most of SQLite's own take no bytes (in bytes).
_MIN_ROW = 4
# How long SQLite may look for one row: some seconds for any file, and more for
# a large one (in seconds, and in bytes per second).
_PATIENCE, _SPEED = 3.0, 20e6
# How many steps SQLite takes before it asks whether to go on.
_STEPS = 20_000

Row = tuple[Any, ...]


class RowsEndError(ValueError):
    """No more rows are read, for there would be no end of it."""


class SqliteDatabase:
    """The tables of one file."""

    def __init__(self, path: Path, limits: ReadLimits, size: int):
        """Opens the file to read it.

        Args:
            path: the file.
            limits: for the length of a value.
            size: of the file, and of the journal beside it (in bytes).
        """
        self._size = size
        self._deadline = 0.0
        self._database = _connect(path)
        self._database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, limits.message)
        self._database.set_progress_handler(self._IsLate, _STEPS)

    def close(self) -> None:
        """Closes the file."""
        self._database.close()

    def HasTable(self, name: str) -> bool:
        """Tells if there is a table of a name.

        Raises:
            LogError: there is something else of that name.
            sqlite3.Error: the file is damaged.
        """
        rows = list(
            self.Rows(
                "SELECT type, sql FROM sqlite_master WHERE name = ?", (name,)
            )
        )
        for kind, text in rows:
            if kind != "table" or not _is_plain(str(text)):
                raise LogError(
                    f"its {name!r} is no table that a recorder makes, but "
                    f"{str(text)[:80]!r}; export the rows to a table"
                )
        return bool(rows)

    def Rows(self, query: str, parameters: Row = ()) -> Iterator[Row]:
        """Yields the rows of a query.

        Raises:
            RowsEndError: there are more than the file can hold, or SQLite took
                too long.
            sqlite3.Error: the file is damaged.
        """
        length = 0
        self._StartClock()
        try:
            rows = self._database.execute(query, parameters)
            for count, row in enumerate(rows):
                length += sum(len(v) for v in row if isinstance(v, str | bytes))
                if count * _MIN_ROW > self._size or length > 2 * self._size:
                    raise RowsEndError(
                        "it has more rows than the file can hold"
                    )
                yield row
                self._StartClock()
        except sqlite3.OperationalError as error:
            if error.sqlite_errorcode != sqlite3.SQLITE_INTERRUPT:
                raise
            raise RowsEndError("SQLite took too long for one row") from error

    def _StartClock(self) -> None:
        patience = _PATIENCE + self._size / _SPEED
        self._deadline = time.process_time() + patience

    def _IsLate(self) -> bool:
        return time.process_time() > self._deadline


def whole_pages(path: Path, folder: Path) -> tuple[Path, str]:
    """Returns the file, or a copy in a folder that ends with a whole page.

    Where a page is cut off, SQLite would read zeros.

    Args:
        path: the file.
        folder: for the copy.

    Returns:
        The path, and a sentence if the file is cut off.
    """
    path = path.absolute()
    size = path.stat().st_size
    with path.open("rb") as file:
        header = file.read(32)
    page = int.from_bytes(header[16:18], "big")
    page = 65536 if page == 1 else page
    expected = page * int.from_bytes(header[28:32], "big")
    said = ""
    if size < expected:
        said = f"the file is cut off: it has {size} of {expected} bytes"
    if not page or size % page == 0:
        return path, said
    copy = folder / path.name
    shutil.copyfile(path, copy)
    os.truncate(copy, size - size % page)
    return copy, said


def _connect(path: Path) -> sqlite3.Connection:
    # Without a journal beside it nothing else writes to the file.
    journal = path.with_name(path.name + "-wal")
    mode = "mode=ro" if journal.exists() else "mode=ro&immutable=1"
    database = sqlite3.connect(f"file:{quote(str(path))}?{mode}", uri=True)
    database.text_factory = lambda text: text.decode(errors="replace")
    # Otherwise SQLite refuses a file whose end is missing.
    database.execute("PRAGMA writable_schema = ON")
    database.execute("PRAGMA trusted_schema = OFF")
    return database


def _is_plain(text: str) -> bool:
    """Tells if a table's definition has nothing in it that is worked out."""
    words = re.findall(r"\w+", text.upper())
    return words[:2] == ["CREATE", "TABLE"] and "AS" not in words
