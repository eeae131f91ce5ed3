"""It is known where everything in a scene is."""

from filter_fixtures import SCENES
import numpy as np

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.scene.prediction_model import MakePredictionModel


def test_there_are_boxes_around_all_models_in_the_world():
    scene = LoadScene(SCENES / "cheezit_1.yaml")
    facts = MakePredictionModel(scene).facts
    lowest, highest = facts.boxes[:, 0], facts.boxes[:, 1]
    assert np.all(lowest <= highest)
    # The object stands on the table.
    p_WO = facts.nominal["cracker"]
    around = np.all((lowest <= p_WO) & (p_WO <= highest), axis=1)
    assert np.any(around)
    (box,) = facts.boxes[around]
    # The carton is 213 mm high, but lies on its side or stands.
    assert np.all(box[1] - box[0] < 0.25)
    assert abs(box[0, 2]) < 0.002
