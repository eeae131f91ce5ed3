"""The picture of what a camera sees, against its own rendering."""

from pathlib import Path

from matplotlib.image import imread
import numpy as np
import pytest

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams import draw_camera_views
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.log.mcap_log_writer import WriteLog
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder

FOLDER = data_folder("diagrams")


def load_scene() -> Scene:
    return LoadScene(FOLDER / "scenes" / "cheezit_1.yaml")


@pytest.fixture(scope="module")
def log() -> Log:
    scene = load_scene()
    return ReadLog(
        filename=FOLDER / "logs" / "cheezit_1.mcap",
        scene=scene,
        joint_names=MakePredictionModel(scene).joint_names,
    )


YELLOW, GREEN = [255, 213, 0], [25, 224, 90]


# The estimate's wireframe covers a part of the detection's.
@pytest.mark.parametrize(
    ("method", "pixels"),
    [("dope", {300: [YELLOW]}), ("cvpf", {100: [YELLOW, GREEN]})],
)
def test_picture_has_a_view_per_time_and_all_wireframes(
    tmp_path: Path, method, pixels
):
    out = tmp_path / "views.png"
    args = ["--method", method, "--times", "2", "5", "--out", str(out)]
    assert draw_camera_views.main(args) == 0
    picture = 255 * imread(out)[..., :3]
    for least, colors in pixels.items():
        for color in colors:
            drawn = np.all(np.abs(picture - color) < 10, axis=2)
            left, right = np.array_split(drawn, 2, axis=1)
            assert left.sum() > least and right.sum() > least


def test_log_without_ground_truth_is_refused(tmp_path, log, capsys):
    scene = load_scene()
    path = tmp_path / "log.mcap"
    untrue = Log(log.joints, log.detections, {}, log.start_time)
    WriteLog(filename=path, scene_topics=scene.topics, log=untrue)
    args = ["--method", "dope", "--log", str(path), "--times", "2"]
    assert (
        draw_camera_views.main([*args, "--out", str(tmp_path / "x.png")]) == 1
    )
    assert "no ground truth of 'cracker'" in capsys.readouterr().err
