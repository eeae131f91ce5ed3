import os
from pathlib import Path
import signal
import subprocess
import sys
import textwrap
import time

import pytest

from pbpf_drake.diagrams.jobs.result_store import (
    ResultStore,
    key_digest,
    write_atomically,
)

KEY = {"log": "abc", "config": {"seed": 1, "noise": 0.02}}


def _store(folder) -> ResultStore:
    return ResultStore(folder / "results", suffix=".json")


def test_what_was_stored_is_there_for_another_process(tmp_path):
    path = _store(tmp_path).Save("scene", KEY, b"content")
    assert _store(tmp_path).Load("scene", KEY) == b"content"
    assert path.name.startswith("scene-") and path.suffix == ".json"
    assert [p.name for p in (tmp_path / "results").iterdir()] == [path.name]


def test_what_was_not_stored_is_none(tmp_path):
    assert _store(tmp_path).Load("scene", KEY) is None


@pytest.mark.parametrize(
    "other", [{"log": "abd"}, {"config": {"seed": 2, "noise": 0.02}}]
)
def test_a_result_is_only_found_under_all_that_it_depends_on(tmp_path, other):
    dut = _store(tmp_path)
    dut.Save("scene", KEY, b"content")
    assert dut.Load("scene", KEY | other) is None
    assert dut.Load("scene_2", KEY) is None


def test_a_key_does_not_depend_on_the_order_of_its_parts():
    assert key_digest({"a": 1, "b": 2}) == key_digest({"b": 2, "a": 1})
    assert key_digest({"a": 1, "b": 2}) != key_digest({"a": 2, "b": 1})


@pytest.mark.parametrize("damage", [b"", b"conte", b"Content", b"content\0"])
def test_a_damaged_file_is_as_good_as_none_and_that_is_said(tmp_path, damage):
    dut = _store(tmp_path)
    path = dut.Save("scene", KEY, b"content")
    path.write_bytes(damage)
    assert dut.Load("scene", KEY) is None
    (note,) = dut.notes
    assert str(path) in note and "damaged" in note
    dut.Save("scene", KEY, b"content")
    assert dut.Load("scene", KEY) == b"content"


def test_names_with_special_letters_are_names(tmp_path):
    dut = _store(tmp_path)
    dut.Save("a[1]", KEY, b"content")
    assert dut.Load("a[1]", KEY) == b"content"
    assert dut.Load("a1", KEY) is None


def test_a_file_that_cannot_be_written_leaves_nothing(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError("no space left")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(OSError, match="no space left"):
        write_atomically(tmp_path / "file", b"content")
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_readable_to_whom_the_umask_lets(tmp_path):
    (tmp_path / "usual").touch()
    write_atomically(tmp_path / "file", b"content")
    modes = {path.stat().st_mode for path in tmp_path.iterdir()}
    assert len(modes) == 1


def test_a_writer_that_is_killed_leaves_whole_files_only(tmp_path):
    """It writes the same file over and over, until it is killed."""
    path, size = tmp_path / "file", 300_000
    code = f"""
    from pathlib import Path
    from pbpf_drake.diagrams.jobs.result_store import write_atomically
    i = 0
    while True:
        i = (i + 1) % 10
        write_atomically(Path({str(path)!r}), str(i).encode() * {size})
    """
    for _ in range(3):
        with subprocess.Popen(
            [sys.executable, "-P", "-c", textwrap.dedent(code)]
        ) as writer:
            before = path.stat().st_mtime_ns if path.exists() else 0
            end = time.monotonic() + 30
            while not path.exists() or path.stat().st_mtime_ns == before:
                assert time.monotonic() < end
            time.sleep(0.03)
            writer.send_signal(signal.SIGKILL)
        data = Path(path).read_bytes()
        assert len(data) == size and len(set(data)) == 1
