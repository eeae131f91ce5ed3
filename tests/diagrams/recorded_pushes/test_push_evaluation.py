"""How evaluations of recorded pushes are run."""

import csv
from dataclasses import replace
import itertools

from filter_fixtures import make_push_log, planar_scene
import numpy as np
from push_fixtures import file_and_seed
import pytest

from pbpf_drake.diagrams.recorded_pushes.push_evaluation import (
    COMPARED_METHODS,
    ConfigForPushes,
    PushEvaluation,
    RunEvaluation,
    ThroughMcap,
)

EVALUATION = PushEvaluation(
    name="evaluate_nothing",
    description="Evaluates nothing.\n\nHow is not shown.",
    recordings="CSV files",
    pattern="*.csv",
    seeds=2,
    out="nothing.csv",
    make_jobs=lambda files, num_seeds: itertools.product(
        files, range(num_seeds)
    ),
    evaluate=file_and_seed,
    make_table=lambda rows: iter(["| rows |", f"| {len(rows)} |"]),
)


def _run(folder, *options: str, **changes) -> int:
    arguments = [str(folder), "--jobs", "1", "--out", str(folder / "out")]
    return RunEvaluation(replace(EVALUATION, **changes), [*arguments, *options])


def test_every_recording_is_evaluated_with_every_seed(tmp_path, capsys):
    for name in "b.csv", "a.csv", "c.txt":
        (tmp_path / name).touch()
    assert _run(tmp_path, "--seeds", "3") == 0
    with (tmp_path / "out").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["run"], row["seed"]) for row in rows] == [
        (run, seed) for run in "ab" for seed in "012"
    ]
    assert capsys.readouterr().out.startswith("| rows |\n| 6 |\nWritten to")


def test_a_folder_without_recordings_is_refused(tmp_path, capsys):
    (tmp_path / "a.txt").touch()
    assert _run(tmp_path) == 1
    said = f"evaluate_nothing: there are no CSV files in {tmp_path}\n"
    assert capsys.readouterr().err == said


def test_recordings_with_nothing_to_evaluate_are_refused(tmp_path, capsys):
    (tmp_path / "a.csv").touch()
    assert _run(tmp_path, make_jobs=lambda files, num_seeds: []) == 1
    assert "there is nothing to evaluate in" in capsys.readouterr().err


def test_the_first_line_of_the_description_is_shown(capsys):
    with pytest.raises(SystemExit):
        RunEvaluation(EVALUATION, ["--help"])
    shown = capsys.readouterr().out
    assert "Evaluates nothing." in shown and "folder of CSV files" in shown
    assert "How" not in shown


@pytest.mark.parametrize("method", COMPARED_METHODS)
def test_only_pbpf_recovers_lost_tracks(method):
    config = ConfigForPushes(planar_scene(), method, 5)
    assert config.seed == 5
    assert config.recover_lost_tracks == (method == "pbpf")


def test_a_log_is_the_same_behind_a_file():
    log, scene = make_push_log(duration=0.5), planar_scene()
    read = ThroughMcap(log, scene)
    assert read.warnings == ()
    np.testing.assert_allclose(read.joints.positions, log.joints.positions)
    assert [d.name for d in read.detections] == [d.name for d in log.detections]
