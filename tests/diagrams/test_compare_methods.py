"""The comparison of methods, on a second of the shipped log."""

from contextlib import redirect_stdout
import csv
from dataclasses import replace
import io

import numpy as np
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.compare_methods import main
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.mcap_log_writer import WriteLog
from pbpf_drake.results.pose_errors import compute_errors
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.tracking_diagram import DefaultConfig, Track

LOG = data_folder("diagrams") / "logs" / "cheezit_1.mcap"
SCENE = data_folder("diagrams") / "scenes" / "cheezit_1.yaml"


def _write_short_log(filename):
    """Writes the log's first 0.7 s, which are four updates."""
    scene = LoadScene(SCENE)
    names = MakePredictionModel(scene).joint_names
    log = ReadLog(filename=LOG, scene=scene, joint_names=names)
    keep, joints = log.joints.times < 0.7, log.joints
    short = replace(
        log,
        joints=replace(
            joints,
            times=joints.times[keep],
            positions=joints.positions[keep],
            velocities=joints.velocities[keep],
        ),
        detections=tuple(d for d in log.detections if d.received < 0.7),
    )
    WriteLog(filename=filename, scene_topics=scene.topics, log=short)
    return ReadLog(filename=filename, scene=scene, joint_names=names)


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    log = _write_short_log(folder / "short.mcap")
    options = ["--log", str(folder / "short.mcap"), "--out", str(folder)]
    options += ["--methods", "pbpf", "dope", "--seeds", "2", "--jobs", "1"]
    with redirect_stdout(io.StringIO()) as printed:
        assert main(options) == 0
    with (folder / "compare.csv").open(newline="") as file:
        return log, list(csv.DictReader(file)), printed.getvalue()


def test_each_seed_has_a_row_and_dope_one(compared):
    _, rows, _ = compared
    runs = [(row["object"], row["method"], row["seed"]) for row in rows]
    assert runs == [
        ("cracker", "pbpf", "0"),
        ("cracker", "pbpf", "1"),
        ("cracker", "dope", "0"),
    ]
    assert rows[0]["position_error_m"] != rows[1]["position_error_m"]


@pytest.mark.parametrize(
    "index, method, seed", [(1, "pbpf", 1), (2, "dope", 0)]
)
def test_a_row_holds_the_mean_errors_of_a_run(compared, index, method, seed):
    log, rows, _ = compared
    scene = LoadScene(SCENE)
    config = replace(DefaultConfig(scene, method), seed=seed)
    record = Track(scene=scene, log=log, method=method, config=config)
    errors = compute_errors(record, "cracker", log.ground_truth["cracker"])
    for name, values in (
        ("position_error_m", errors.position),
        ("rotation_error_rad", errors.rotation),
    ):
        assert float(rows[index][name]) == pytest.approx(np.mean(values))


def test_the_table_has_means_over_seeds_and_their_ratios(compared):
    _, rows, printed = compared
    errors = [float(row["position_error_m"]) for row in rows]
    lines = [line.split() for line in printed.splitlines()]
    assert lines[0][:3] == ["object", "method", "runs"]
    assert lines[1][:3] == ["cracker", "pbpf", "2"]
    mean = np.mean(errors[:2])
    expected = [mean, np.std(errors[:2]), mean / errors[2]]
    np.testing.assert_allclose(np.float64(lines[1][3:6]), expected, atol=1e-4)
    assert lines[2][:3] == ["cracker", "dope", "1"]
    assert lines[2][4:6] == ["0.0000", "1.0000"]


def test_a_log_that_is_missing_is_said_in_one_line(tmp_path, capsys):
    options = ["--log", "nowhere.mcap", "--out", str(tmp_path)]
    assert main([*options, "--methods", "dope", "--jobs", "1"]) == 1
    assert "nowhere.mcap" in capsys.readouterr().err.splitlines()[-1]
