"""The picture of scenes, against the log that comes with the package."""

from matplotlib.image import imread
import numpy as np
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams import draw_scenes
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder

FOLDER = data_folder("diagrams")
LOG = FOLDER / "logs" / "cheezit_1.mcap"


def _red(image: np.ndarray) -> int:
    """How many pixels have the cracker box's red."""
    r, g, b = np.moveaxis(image.astype(int), -1, 0)
    return np.count_nonzero((r > 90) & (g < 40) & (b < 40))


def test_box_is_seen_before_it_is_behind_the_obstacle():
    scene = LoadScene(FOLDER / "scenes" / "cheezit_1.yaml")
    names = MakePredictionModel(scene).joint_names
    log = ReadLog(filename=LOG, scene=scene, joint_names=names)
    times = np.array([4.0, 15.0])
    seen, hidden = draw_scenes.render_log(scene, log, times)
    assert seen.shape == (480, 640, 3)
    assert _red(seen) > 500 and _red(hidden) < 0.3 * _red(seen)
    untrue = Log(log.joints, log.detections, {}, log.start_time)
    with pytest.raises(ValueError, match="no ground truth of .'cracker'"):
        draw_scenes.render_log(scene, untrue, times)


def test_picture_is_written(tmp_path):
    out = tmp_path / "new_folder" / "scenes.png"
    assert draw_scenes.main([str(LOG), "--out", str(out)]) == 0
    assert np.ptp(imread(out)) > 0.5
