import math

import pytest
from recording_fixtures import make_planar_scene

from pbpf_drake.config.path_config import PathConfig, Waypoint


@pytest.mark.parametrize("translation", [[0.0, 0.0], [0.0, math.nan, 0.0]])
def test_a_bad_waypoint_is_refused_by_its_index(translation):
    config = make_planar_scene().recording
    config.path.waypoints[1].translation = translation
    with pytest.raises(ValueError, match=r"waypoints\[1\].translation"):
        config.ValidateOrThrow()


def test_waypoints_at_the_same_time_are_refused_with_their_times():
    path = PathConfig(end_effector="hand", waypoints=[Waypoint(time=1.0)] * 2)
    expected = r"^path\.waypoints is \[1.0, 1.0\]; expected .* increasing"
    with pytest.raises(ValueError, match=expected):
        path.ValidateOrThrow("path")
