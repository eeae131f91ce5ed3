"""The command that compares the simulated detector with real traces."""

import csv
from pathlib import Path

import pytest

from pbpf_drake.diagrams.compare_detector import main


def _write_trace(folder: Path) -> None:
    """A trace of Cheezit 1 that is 0.05 m and 0.2 rad off all the time."""
    for kind, error in ("pos", 0.05), ("ang", 0.2):
        lines = [f"{i},{0.16 * i:.2f},{error},DOPE\n" for i in range(1, 40)]
        name = f"cracker_scene1_early_DOPE_{kind}_01.csv"
        (folder / name).write_text("".join(lines))


@pytest.mark.parametrize(
    "options, said",
    [
        (["--runs", "0"], "--runs is 0; expected at least 1"),
        (["--draws", "-1"], "--draws is -1; expected at least 1"),
        (["--jobs", "0"], "--jobs is 0; expected at least 1"),
    ],
)
def test_what_cannot_be_done_is_said_before_anything_is_recorded(
    options, said, tmp_path, capsys
):
    _write_trace(tmp_path)
    assert main([str(tmp_path), *options]) == 1
    assert capsys.readouterr().err == f"compare_detector: {said}\n"


def test_a_folder_that_is_missing_or_without_traces_is_said(tmp_path, capsys):
    assert main([str(tmp_path / "nowhere")]) == 1
    assert "There is no folder" in capsys.readouterr().err
    assert main([str(tmp_path)]) == 1
    assert f"There is no trace in {tmp_path}" in capsys.readouterr().err


@pytest.mark.slow
def test_the_command_puts_the_real_and_the_simulated_side_by_side(
    tmp_path, capsys
):
    _write_trace(tmp_path)
    out = tmp_path / "new" / "detector.csv"
    options = ["--scenes", "cheezit_1", "--runs", "1", "--draws", "3"]
    assert (
        main([str(tmp_path), *options, "--jobs", "1", "--out", str(out)]) == 0
    )
    with open(out, newline="", encoding="utf-8") as file:
        rows = {row["statistic"]: row for row in csv.DictReader(file)}
    mean = rows["position: mean"]
    assert (mean["scene"], mean["object"]) == ("cheezit_1", "cracker")
    assert (mean["real_trace"], mean["paper"]) == ("0.0500", "0.2890")
    low, high = (float(mean[f"simulated_{q}"]) for q in ("05", "95"))
    assert 0.05 < low < high < 1.0
    shares = [
        rows[f"images: {x}"] for x in ("clear", "partly hidden", "hidden")
    ]
    assert sum(float(s["simulated_50"]) for s in shares) == pytest.approx(
        1, abs=1e-3
    )
    # The box is pushed behind an obstacle.
    assert float(shares[0]["simulated_50"]) > 0.2
    assert float(shares[2]["simulated_50"]) > 0.4
    assert "outside" in capsys.readouterr().out
