"""The benchmark as a command, with few particles and updates."""

from contextlib import redirect_stdout
from importlib.util import find_spec
import io
import json
import math
import re

import pytest

from pbpf_drake.diagrams.benchmark.benchmark_filter import STAGES
from pbpf_drake.diagrams.benchmark_update import main

KEYS = [
    "engine",
    "particles",
    "objects",
    "threads",
    "stage",
    "median_ms",
    "p95_ms",
    "max_ms",
    "error_mm",
    "error_rad",
]
TINY = ["--particles", "6", "--updates", "3", "--samples", "1"]


def _run(file, *options):
    with redirect_stdout(io.StringIO()) as printed:
        assert main([*TINY, "--json", str(file), *options]) == 0
    return json.loads(file.read_text(encoding="utf-8")), printed.getvalue()


@pytest.fixture(scope="module")
def measured(tmp_path_factory):
    file = tmp_path_factory.mktemp("benchmark") / "rows.json"
    return _run(file, "--threads", "1")


def _check(row) -> None:
    assert list(row) == KEYS
    assert 0 < row["median_ms"] <= row["p95_ms"] <= row["max_ms"]
    assert 0 <= row["error_mm"] < math.inf
    assert 0 <= row["error_rad"] < math.inf


def test_there_is_a_row_for_every_stage_of_every_case(measured):
    rows, _ = measured
    found = [(row["objects"], row["stage"]) for row in rows]
    assert found == [(k, stage) for k in (1, 3) for stage in STAGES]
    for row in rows:
        assert (row["engine"], row["particles"], row["threads"]) == (
            "pbpf",
            6,
            1,
        )
        _check(row)


def test_no_stage_is_longer_than_the_whole(measured):
    rows, _ = measured
    for k in (1, 3):
        times = {r["stage"]: r["max_ms"] for r in rows if r["objects"] == k}
        whole = times.pop("total")
        assert all(time <= whole for time in times.values())
        medians = [
            r["median_ms"]
            for r in rows
            if r["objects"] == k and r["stage"] != "total"
        ]
        assert sum(medians) <= whole * (1 + 1e-9)


def test_tables_are_printed_with_the_numbers_of_the_rows(measured):
    rows, printed = measured
    total = next(r for r in rows if r["stage"] == "total")
    line = next(x for x in printed.splitlines() if x.startswith("| 6 | 1 |"))
    cells = [cell.strip() for cell in line[1:-1].split("|")]
    assert f"{total['median_ms']:.2f}" in cells
    assert f"{160 / total['median_ms']:.2f}" in cells
    assert f"{total['error_mm']:.3f}" in printed
    assert "moved in an update" in printed


def test_json_in_a_folder_that_is_not_there_is_refused_at_once(capsys):
    assert main([*TINY, "--json", "nowhere/rows.json"]) == 1
    assert "no folder nowhere" in capsys.readouterr().err


def test_peers_that_are_missing_are_named_with_how_to_get_them(
    monkeypatch, capsys
):
    monkeypatch.setattr(
        "pbpf_drake.diagrams.benchmark.other_engines.find_spec",
        lambda name: None if name == "mujoco" else object(),
    )
    assert main([*TINY, "--peers"]) == 1
    message = capsys.readouterr().err
    assert "mujoco" in message and "pybullet" not in message
    assert 'pip install "pbpf_drake[peers]"' in message


@pytest.mark.skipif(
    not all(map(find_spec, ("pybullet", "mujoco"))),
    reason='needs other engines: pip install "pbpf_drake[peers]"',
)
def test_peers_make_the_same_predictions(tmp_path):
    options = ["--threads", "1", "--objects", "1", "--peers"]
    rows, printed = _run(tmp_path / "rows.json", *options)
    peers = rows[len(STAGES) :]
    found = [(row["engine"], row["stage"]) for row in peers]
    assert found == [("pybullet", "motion"), ("mujoco", "motion")]
    for row in peers:
        _check(row)
        # All engines push the same box with the same hand.
        assert 0 < row["error_mm"] < 5
    assert "Engines" in printed


def test_memory_is_printed_over_the_updates_and_stays(capsys):
    """A leak of a context, 0.4 MB, per update would show."""
    options = ["--endurance", "40", "--objects", "1", "--threads", "1"]
    assert main(["--particles", "4", *options]) == 0
    printed = capsys.readouterr()
    rows = re.findall(r"(\d+) updates +([\d.]+) MB", printed.out + printed.err)
    assert [int(updates) for updates, _ in rows] == list(range(2, 41, 2))
    growth = float(re.search(r"(-?[\d.]+) kB per update", printed.out).group(1))
    assert growth < 200
