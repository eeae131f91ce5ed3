import numpy as np
import pytest
from recording_fixtures import SCENES, make_parameters

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.truth.truth_model import MakeTruth, MakeTruthContext


def _check(change_last_waypoint: np.ndarray) -> None:
    """Checks the shipped path with its last waypoint changed."""
    scene = LoadScene(SCENES / "cheezit_1.yaml")
    last = scene.recording.path.waypoints[-1]
    last.translation = list(last.translation + change_last_waypoint)
    parameters = make_parameters(scene)
    truth = MakeTruth(scene=scene, parameters=parameters)
    MakeTruthContext(truth=truth, parameters=parameters)


def test_shipped_path_runs_into_nothing():
    _check(np.zeros(3))


@pytest.mark.parametrize(
    "change, obstacle",
    [([0.0, 0.0, -0.1], "table::top"), ([0.2, -0.17, 0.0], "obstacle::")],
)
def test_a_path_into_something_fixed_is_refused_by_name(change, obstacle):
    with pytest.raises(ValueError, match=f"recording.path at .*{obstacle}"):
        _check(np.array(change))
