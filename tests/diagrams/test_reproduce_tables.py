"""The whole command, on two scenes, 2 x 2, with short logs and few particles.

It is killed in mid-run and started again.
"""

from contextlib import redirect_stdout
import csv
import io
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from pbpf_drake.diagrams.jobs.scene_run import SceneRun
from pbpf_drake.diagrams.paper import protocol_runner
from pbpf_drake.diagrams.paper.evaluation import Evaluation, read_result
from pbpf_drake.diagrams.reproduce_tables import main
from pbpf_drake.scene.scene_models import data_folder

SCENES = ("cheezit_1", "cheezit_gelatin_soup")
METHODS = ("pbpf", "cvpf", "dope")
OPTIONS = [
    *("--scenes", *SCENES, "--methods", *METHODS),
    *("--runs", "2", "--repeats", "2"),
    *("--duration", "0.7", "--particles", "3", "--jobs", "2"),
]
# Two scenes and runs; two repeats of two methods, one of DOPE.
COUNT = 2 * 2 * (2 * 2 + 1)


def _results(folder: Path) -> dict[str, int]:
    """The stored results, and when they were written."""
    files = (folder / "evaluations").glob("*.json")
    return {path.name: path.stat().st_mtime_ns for path in files}


def _run(folder: Path, *more: str) -> str:
    with redirect_stdout(io.StringIO()) as printed:
        assert main([*OPTIONS, "--out", str(folder), *more]) == 0
    return printed.getvalue()


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory):
    """The folder, what was stored when it was killed, and what was printed."""
    folder = tmp_path_factory.mktemp("tables")
    command = [
        sys.executable,
        "-P",
        "-m",
        "pbpf_drake.diagrams.reproduce_tables",
    ]
    with subprocess.Popen(
        [*command, *OPTIONS, "--out", str(folder)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as process:
        end = time.monotonic() + 300
        while len(_results(folder)) < 5:
            assert process.poll() is None and time.monotonic() < end
            time.sleep(0.02)
        process.send_signal(signal.SIGKILL)
    stored = _results(folder)
    return folder, stored, _run(folder)


@pytest.mark.slow
def test_what_was_stored_when_it_was_killed_is_not_computed_again(reproduced):
    folder, stored, _ = reproduced
    assert 5 <= len(stored) < COUNT
    after = _results(folder)
    assert len(after) == COUNT
    assert {name: after[name] for name in stored} == stored


@pytest.mark.slow
def test_started_again_it_computes_nothing_and_says_the_same(
    reproduced, monkeypatch
):
    folder, _, printed = reproduced
    monkeypatch.setattr(protocol_runner, "evaluate", None)
    monkeypatch.setattr(protocol_runner, "record", None)
    before = _results(folder)
    assert _run(folder) == printed
    assert _results(folder) == before


@pytest.mark.slow
def test_the_tables_are_of_the_stored_results(reproduced):
    folder, _, printed = reproduced
    text = (folder / "paper_tables.csv").read_text()
    rows = list(csv.DictReader(io.StringIO(text)))
    objects = [
        n for n in ("cracker", "cracker", "gelatin", "soup") for _ in METHODS
    ]
    assert [row["object"] for row in rows] == objects
    files = (folder / "evaluations").glob("cheezit_1-run_*-pbpf-repeat_*")
    evaluation = Evaluation(SceneRun("cheezit_1", 0), "pbpf", 0)
    results = [read_result(evaluation, f.read_bytes()) for f in files]
    assert len(results) == 4
    errors = np.concatenate([r.errors["cracker"]["position"] for r in results])
    errors = errors[np.isfinite(errors)]
    assert rows[0]["method"] == "pbpf" and rows[0]["runs"] == "2"
    assert float(rows[0]["pos_mean"]) == pytest.approx(errors.mean(), abs=1e-6)
    assert float(rows[0]["pos_std"]) == pytest.approx(errors.std(), abs=1e-6)
    assert rows[0]["paper_pos_mean"] == "0.081"
    assert f"{errors.mean():.3f} ± {errors.std():.3f}" in printed
    assert "Not the paper's protocol: logs of 0.7 s, 3 particles." in printed


@pytest.mark.slow
def test_all_files_are_written(reproduced):
    folder, _, _ = reproduced
    names = {path.name for path in folder.iterdir()}
    assert names == {
        *("logs", "evaluations", "tables.txt", "tables.md"),
        *("paper_tables.csv", "metrics.csv", "comparisons.csv"),
        *(f"errors_{scene}.png" for scene in SCENES),
    }
    assert len(list((folder / "logs").glob("*.mcap"))) == 4


@pytest.mark.slow
def test_a_damaged_result_is_computed_again_and_that_is_said(
    reproduced, capsys
):
    folder, _, printed = reproduced
    path = next((folder / "evaluations").glob("cheezit_1-run_1-dope-*"))
    good = path.read_bytes()
    path.write_bytes(good[:-9])
    assert _run(folder) == printed
    assert path.read_bytes() == good
    assert f"{path} is damaged; it is made again" in capsys.readouterr().err


@pytest.mark.slow
def test_a_cluster_finds_the_same_to_the_bit(reproduced, tmp_path):
    distributed = pytest.importorskip(
        "distributed", reason="the extra 'cluster' is not installed"
    )
    folder, _, _ = reproduced
    with distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        dashboard_address=":0",
        silence_logs=50,
    ) as cluster:
        address = cluster.scheduler_address
        few = ["--scenes", "cheezit_1", "--methods", "cvpf", "--runs", "1"]
        _run(tmp_path, *few, "--scheduler", address)
    found = list((tmp_path / "evaluations").iterdir())
    assert len(found) == 2
    for path in found:
        same = folder / "evaluations" / path.name
        assert path.read_bytes() == same.read_bytes()


@pytest.mark.slow
def test_what_fails_is_named_at_the_end_and_the_others_are_done(
    reproduced, capsys, tmp_path
):
    folder, _, _ = reproduced
    bad = tmp_path / "bad.yaml"
    text = (data_folder("diagrams") / "scenes/cheezit_1.yaml").read_text()
    bad.write_text(text.replace("end_effector: panda_hand", "end_effector: x"))
    options = ["--scenes", "cheezit_1", str(bad), "--methods", "dope"]
    options += ["--runs", "1", "--repeats", "1", "--duration", "0.7"]
    options += ["--particles", "3", "--jobs", "1", "--out", str(folder)]
    assert main(options) == 1
    said = capsys.readouterr()
    assert "1 failed, the others are stored" in said.err
    assert "bad-run_0: ValueError: " in said.err
    assert "Cheezit Scene 1" in said.out
    for tables in said.out, (folder / "tables.md").read_text():
        assert "without what failed (bad-run_0)" in tables


@pytest.mark.slow
def test_an_interruption_ends_all_of_it_in_a_line(tmp_path):
    """From the keyboard, which interrupts its processes as well."""
    command = [sys.executable, "-m", "pbpf_drake.diagrams.reproduce_tables"]
    with subprocess.Popen(
        [*command, *OPTIONS, "--out", str(tmp_path)],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
        cwd=tmp_path,
        # Who runs these tests in the background has them ignore it.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as process:
        end = time.monotonic() + 300
        while not list(tmp_path.glob("logs/*.mcap")):
            assert process.poll() is None and time.monotonic() < end
            time.sleep(0.02)
        os.killpg(process.pid, signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "reproduce_tables: interrupted" in said
    assert "Traceback" not in said


@pytest.mark.parametrize(
    "options, said",
    [
        (["--jobs", "0"], "--jobs is 0; expected at least 1"),
        (["--runs", "0"], "--runs is 0; expected between 1 and 1000"),
        (["--scenes", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_what_cannot_be_done_is_a_sentence(options, said, capsys, tmp_path):
    assert main([*OPTIONS, *options, "--out", str(tmp_path)]) == 1
    error = capsys.readouterr().err.splitlines()[-1]
    assert error.startswith("reproduce_tables: ") and said in error


def test_a_folder_that_cannot_be_made_is_said_at_once(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert main([*OPTIONS, "--out", str(tmp_path / "file")]) == 1
    error = capsys.readouterr().err
    assert "reproduce_tables: " in error and str(tmp_path / "file") in error
    assert "record" not in error
