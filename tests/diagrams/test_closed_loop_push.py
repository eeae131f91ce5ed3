"""The command that pushes objects to goals."""

import csv

from closed_loop_fixtures import make_outcome

from pbpf_drake.diagrams import closed_loop_push


def test_all_runs_are_written(tmp_path, monkeypatch):
    monkeypatch.setattr(
        closed_loop_push,
        "RunTask",
        lambda scene, feedback, seed: make_outcome(feedback, 0.01 * seed),
    )
    out = tmp_path / "out.csv"
    arguments = ["--goals", "2", "--feedback", "dope", "truth"]
    assert closed_loop_push.main([*arguments, "--out", str(out)]) == 0
    with out.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["feedback"] for row in rows] == ["dope", "truth"] * 2
    assert [row["distance"] for row in rows[2:]] == ["0.0100"] * 2
