"""A robot and an object of a user's own, as the README says."""

import json

import numpy as np
from own_fixtures import SCENE, UR5E, write_arm, write_mug
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams import record_scene, track_log
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.scene.prediction_model import MakePredictionModel


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The user's folder: an arm, a mug and a scene."""
    folder = tmp_path_factory.mktemp("own")
    write_arm(folder / "ur5e.urdf")
    write_mug(folder / "mug.obj")
    (folder / "scene.yaml").write_text(SCENE)
    return folder


def _transform(a: float, d: float, alpha: float, angle: float) -> np.ndarray:
    """The textbook's matrix of one row of Denavit-Hartenberg parameters."""
    c, s = np.cos(angle), np.sin(angle)
    ca, sa = np.cos(alpha), np.sin(alpha)
    return np.array(
        [
            [c, -s * ca, s * sa, a * c],
            [s, c * ca, -c * sa, a * s],
            [0, sa, ca, d],
            [0, 0, 0, 1],
        ]
    )


def test_the_arm_is_what_its_published_parameters_say(folder):
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(folder / "ur5e.urdf"))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("link0"))
    plant.Finalize()
    q = np.array([0.3, -1.0, 0.7, 0.2, 0.5, 0.1])
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    X_WL = plant.GetFrameByName("link6").CalcPoseInWorld(context)
    expected = np.eye(4)
    for row, angle in zip(UR5E, q, strict=True):
        expected = expected @ _transform(*row, angle)
    flange = X_WL @ np.array([0.0, 0.0, UR5E[-1][1]])
    np.testing.assert_allclose(flange, expected[:3, 3], atol=1e-12)


def test_own_arm_and_own_mesh_are_recorded_and_tracked(folder, capsys):
    scene, log, out = (folder / n for n in ("scene.yaml", "a.mcap", "out"))
    arguments = ["--scene", str(scene), "--out", str(log), "--duration", "2.5"]
    assert record_scene.main(arguments) == 0
    assert "mug: moved by" in capsys.readouterr().out
    arguments = ["--scene", str(scene), "--log", str(log), "--out", str(out)]
    options = ["--particles", "12", "--threads", "1"]
    assert track_log.main([*arguments, *options]) == 0
    report = json.loads((out / "report.json").read_text())
    pbpf = report["runs"][0]["objects"]["mug"]
    assert pbpf["detected_share"] > 0.5
    assert pbpf["position_error_m"]["end"] < 0.04


def test_the_pushed_mug_moves_in_the_truth(folder):
    scene = LoadScene(folder / "scene.yaml")
    names = MakePredictionModel(scene).joint_names
    log = ReadLog(filename=folder / "a.mcap", scene=scene, joint_names=names)
    truth = log.ground_truth["mug"].p_WO
    assert truth[-1, 1] - truth[0, 1] > 0.03


def test_a_mug_in_millimetres_is_refused_before_anything_is_done(
    folder, tmp_path, capsys
):
    write_arm(tmp_path / "ur5e.urdf")
    write_mug(tmp_path / "mug.obj", scale=1000)
    (tmp_path / "scene.yaml").write_text(SCENE)
    arguments = ["--scene", str(tmp_path / "scene.yaml")]
    for command in track_log.main, record_scene.main:
        assert command([*arguments, "--out", str(tmp_path / "out")]) == 1
        printed = capsys.readouterr().err
        assert "is its mesh in millimetres? Then write <scale>0.001" in printed
        assert not (tmp_path / "out").exists()
