"""Small files that unpack to gigabytes: refused or read, in bounded time."""

import bz2
from pathlib import Path
import resource
import time

from bag_fixtures import our_entries, write_mcap, write_ros1
from bomb_fixtures import (
    GB,
    lz4_frame,
    mcap_chunk,
    mcap_of_detections,
    with_mcap_chunks,
    with_ros1_chunk,
    write_sqlite,
    zstd_frame,
)
from log_fixtures import has_warning, make_small_log, read_small_log
import pytest
import zstandard

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.mcap_records import MCAP_MAGIC

LOG = make_small_log()
# What one file may take (in seconds of the processor, and kB).
MAX_TIME, MAX_MEMORY = 20.0, 10**6
TABLE = (
    "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, "
    "timestamp INTEGER, data BLOB)"
)
LINE = "\n" + "=" * 80 + "\n"


@pytest.fixture(autouse=True)
def bounded():
    """Measures what a test takes of time and memory."""
    start = time.process_time()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    yield
    after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert time.process_time() - start < MAX_TIME
    assert after - before < MAX_MEMORY


@pytest.fixture(scope="module")
def mcap(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "log.mcap"
    return write_mcap(path, our_entries(LOG)).read_bytes()


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "log.bag"
    return write_ros1(path, our_entries(LOG)).read_bytes()


def _read(path: Path, content: bytes):
    assert len(content) < 20e6
    path.write_bytes(content)
    return read_small_log(path)


@pytest.mark.parametrize(
    "compression, packed, size",
    [
        (b"zstd", zstd_frame(10 * GB), 10 * GB),
        (b"zstd", zstd_frame(10 * GB), 1000),
        (b"lz4", lz4_frame(3 * GB), 65536),
    ],
    ids=["zstd", "zstd-that-lies", "lz4-that-lies"],
)
def test_a_chunk_of_gigabytes_costs_only_itself(
    tmp_path, mcap, compression, packed, size
):
    chunk = mcap_chunk(compression, packed, size)
    log = _read(tmp_path / "log", with_mcap_chunks(mcap, [chunk]))
    assert len(log.joints.times) == len(LOG.joints.times)
    assert has_warning(log, "left out 1 chunk: too long, more than 268.4 MB")


@pytest.mark.parametrize("compression", [b"lz4", b"bz2"])
def test_a_chunk_of_ros1_as_well(tmp_path, bag, compression):
    packed = (
        lz4_frame(3 * GB)
        if compression == b"lz4"
        else bz2.compress(bytes(270_000_000))
    )
    content = with_ros1_chunk(bag, compression, packed, 65536)
    log = _read(tmp_path / "log", content)
    assert len(log.joints.times) == len(LOG.joints.times)
    assert has_warning(log, "left out 1 chunk: too long, more than 268.4 MB")


def test_what_many_chunks_hold_is_bounded(tmp_path, mcap):
    chunk = mcap_chunk(b"zstd", zstd_frame(GB // 5), GB // 5)
    content = with_mcap_chunks(mcap, [chunk] * 50, at_end=True)
    log = _read(tmp_path / "log", content)
    assert len(log.joints.times) == len(LOG.joints.times)
    assert has_warning(log, "what follows is not read", "ReadLimits")


@pytest.mark.slow
def test_a_file_that_fills_the_disk_is_unpacked_in_part(tmp_path, mcap):
    packed = zstandard.compress(mcap[:-100]) + zstd_frame(20 * GB)
    log = _read(tmp_path / "log", packed)
    assert len(log.joints.times) == len(LOG.joints.times)
    assert has_warning(log, "only 536.9 MB were unpacked: see ReadLimits")


def test_a_file_that_is_packed_twice_is_refused(tmp_path):
    packed = zstandard.compress(zstd_frame(20 * GB, MCAP_MAGIC))
    with pytest.raises(LogError, match="a zstd file in a zstd file"):
        _read(tmp_path / "log", packed)


@pytest.mark.parametrize(
    "command",
    [
        "CREATE VIEW messages AS WITH RECURSIVE c(id) AS (SELECT 1 UNION ALL "
        "SELECT id + 1 FROM c) SELECT id, 1 AS topic_id, id AS timestamp, "
        "zeroblob(1000000000) AS data FROM c",
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, "
        "timestamp INTEGER, data BLOB AS (zeroblob(1000000000)))",
    ],
    ids=["view", "column"],
)
def test_a_database_that_works_out_its_messages_is_refused(tmp_path, command):
    path = write_sqlite(tmp_path / "log.db3", command)
    with pytest.raises(LogError, match="'messages' is no table"):
        read_small_log(path)


def test_messages_of_gigabytes_are_left_out_and_counted(tmp_path):
    rows = [(i, 1, i, zstd_frame(GB)) for i in range(1, 51)]
    path = write_sqlite(tmp_path / "log.db3", TABLE, *rows)
    with pytest.raises(LogError) as caught:
        read_small_log(path)
    assert "left out 4 messages too long, more than 134" in str(caught.value)
    assert "left out 46 messages beyond what a log" in str(caught.value)


@pytest.mark.parametrize(
    "definition",
    [
        "string[2000000000] x",
        "\n".join(f"float64 x{i}" for i in range(100_000)),
        LINE.join(
            ["a/T0 x"]
            + [f"MSG: a/T{i}\na/T{i + 1}[1000] x" for i in range(30)]
            + ["MSG: a/T30\nbool x"]
        ),
    ],
    ids=["array", "fields", "nested"],
)
def test_a_definition_without_an_end_is_not_used(tmp_path, definition):
    content = mcap_of_detections(100, definition)
    with pytest.raises(LogError, match="left out 100 messages that can't be"):
        _read(tmp_path / "log", content)


def test_more_records_than_a_file_can_hold_are_not_walked(tmp_path, mcap):
    # Records of a kind that nobody knows, without content.
    count = 20_000_000
    packed = zstandard.compress((b"\x77" + bytes(8)) * count)
    chunk = mcap_chunk(b"zstd", packed, 9 * count)
    with pytest.raises(LogError, match="more than 1000000 records"):
        _read(tmp_path / "log", with_mcap_chunks(mcap, [chunk]))
