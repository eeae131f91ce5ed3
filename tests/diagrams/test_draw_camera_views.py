"""The picture of what a camera sees, against its own rendering."""

from pathlib import Path

from matplotlib.image import imread
import numpy as np
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams import draw_camera_views
from pbpf_drake.diagrams.draw_camera_views import CameraView
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.log.mcap_log_writer import WriteLog
from pbpf_drake.scene.pinhole import in_camera, project_points
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder

FOLDER = data_folder("diagrams")


def load_scene() -> Scene:
    return LoadScene(FOLDER / "scenes" / "cheezit_1.yaml")


def test_box_surrounds_what_is_rendered_of_the_object():
    scene = load_scene()
    view = CameraView(scene)
    # Two pictures: with the object in view, and behind the camera.
    X_WO = RigidTransform([0.5, 0.05, 0.12])
    away = RigidTransform([3.0, 0.0, 0.4])
    q = np.zeros(9)
    pictures = [view.Render(q, [X]).astype(int) for X in (X_WO, away)]
    changed = np.any(pictures[0] != pictures[1], axis=2)
    # Some lone pixels change at the edges of other things.
    u, v = (np.flatnonzero(changed.sum(axis=i) > 5) for i in (0, 1))
    p_C = in_camera(view.BoxEdges(0) + X_WO.translation(), scene.camera)
    edges = project_points(p_C, scene.camera)
    low, high = edges.min(axis=(0, 1)), edges.max(axis=(0, 1))
    assert view.BoxEdges(0).shape == (12, 2, 3)
    np.testing.assert_allclose([u.min(), v.min()], low, atol=3)
    np.testing.assert_allclose([u.max(), v.max()], high, atol=3)


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
    [("dope", {300: [YELLOW]}), ("cvpf", {150: [YELLOW, GREEN]})],
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
