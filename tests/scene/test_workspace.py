from filter_fixtures import SCENES
import numpy as np

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.workspace import MARGIN, FindWorkspace


def test_everything_in_the_scene_is_inside_with_a_margin():
    model = MakePredictionModel(LoadScene(SCENES / "cheezit_1.yaml"))
    low, high = FindWorkspace(model)
    inside = [*model.nominal_poses[:, 4:], *model.fixed_poses()[:, 4:]]
    for position in inside:
        assert np.all(low + MARGIN <= position + 1e-9)
        assert np.all(position <= high - MARGIN + 1e-9)


def test_it_ends_near_the_scene():
    model = MakePredictionModel(LoadScene(SCENES / "cheezit_1.yaml"))
    low, high = FindWorkspace(model)
    # The arm is 0.85 m long, and the table is not much larger.
    assert np.all(high - low < 2 * MARGIN + 3)
    assert not np.all(low <= [0.5, 0.0, -5.0]), "5 m under the floor"
