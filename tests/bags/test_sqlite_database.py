"""Rows come from tables only, and no more of them than a file can hold."""

import sqlite3

from bomb_fixtures import write_sqlite
import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, ReadLimits
from pbpf_drake.bags.sqlite_database import (
    RowsEndError,
    SqliteDatabase,
    whole_pages,
)

TABLE = (
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL,"
    " timestamp INTEGER NOT NULL, data BLOB NOT NULL)"
)
COUNTING = "WITH RECURSIVE c(id) AS (SELECT 1 UNION ALL SELECT id + 1 FROM c) "
ROWS = [(i, 1, i, b"data") for i in range(100)]


@pytest.fixture
def open_database(tmp_path):
    """Returns a function that opens a database made by one command."""
    opened = []

    def open_it(command, *rows, limits=DEFAULT_LIMITS):
        path = write_sqlite(tmp_path / "log.db3", command, *rows)
        database = SqliteDatabase(path, limits, path.stat().st_size)
        opened.append(database)
        return database

    yield open_it
    for database in opened:
        database.close()


def test_a_recorders_table_is_read(open_database):
    database = open_database(TABLE, *ROWS)
    assert database.HasTable("messages") and not database.HasTable("others")
    assert list(database.Rows("SELECT * FROM messages")) == ROWS


@pytest.mark.parametrize(
    "command",
    [
        f"CREATE VIEW messages AS {COUNTING} SELECT id, zeroblob(9) FROM c",
        "CREATE TABLE messages(id INTEGER, data BLOB AS(zeroblob(900000000)))",
    ],
)
def test_what_is_worked_out_is_no_table(open_database, command):
    with pytest.raises(LogError, match="no table that a recorder makes"):
        open_database(command).HasTable("messages")


def test_rows_end_when_there_are_more_than_the_file_can_hold(open_database):
    database = open_database(TABLE, *ROWS)
    with pytest.raises(RowsEndError, match="more rows than"):
        for _ in database.Rows(f"{COUNTING} SELECT id FROM c"):
            pass
    with pytest.raises(RowsEndError, match="more rows than"):
        for _ in database.Rows(f"{COUNTING} SELECT zeroblob(9000) FROM c"):
            pass


def test_a_query_without_an_end_is_stopped(open_database, monkeypatch):
    monkeypatch.setattr("pbpf_drake.bags.sqlite_database._PATIENCE", 0.1)
    database = open_database(TABLE, *ROWS)
    with pytest.raises(RowsEndError, match="took too long"):
        list(database.Rows(f"{COUNTING} SELECT count(*) FROM c"))


def test_no_value_is_longer_than_a_message_may_be(open_database):
    database = open_database(TABLE, *ROWS, limits=ReadLimits(message=1000))
    with pytest.raises(sqlite3.Error, match="too big"):
        list(database.Rows("SELECT zeroblob(1001)"))


def test_a_file_is_copied_only_if_its_last_page_is_cut_off(tmp_path):
    path = write_sqlite(tmp_path / "log.db3", TABLE, *ROWS)
    assert whole_pages(path, tmp_path) == (path, "")
    size = path.stat().st_size
    content = path.read_bytes()[:-100]
    path.write_bytes(content)
    folder = tmp_path / "copies"
    folder.mkdir()
    copy, said = whole_pages(path, folder)
    assert copy.parent == folder and copy.stat().st_size % 4096 == 0
    assert said == f"the file is cut off: it has {size - 100} of {size} bytes"
