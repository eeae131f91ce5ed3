import math

import pytest
from recording_fixtures import SCENES, make_planar_scene

from pbpf_drake.config.distributions import PoseStddev, Range
from pbpf_drake.config.path_config import Waypoint
from pbpf_drake.config.recording_config import RecordingConfig
from pbpf_drake.config.scene_config import LoadScene


def test_shipped_scene_can_be_recorded():
    LoadScene(SCENES / "cheezit_1.yaml").recording.ValidateOrThrow()


def test_without_a_path_there_is_nothing_to_record():
    with pytest.raises(ValueError, match="recording.path.end_effector is ''"):
        RecordingConfig().ValidateOrThrow()


@pytest.mark.parametrize(
    "field, value",
    [
        ("duration", 0.0),
        ("duration", math.nan),
        ("duration", 1e200),
        ("time_step", 1e-12),
        ("joint_period", 1e-12),
        ("mass_scale", Range(min=0.5, max=1e200)),
        ("stiffness", [1e200]),
        ("path.waypoints", [Waypoint(time=0.0), Waypoint(time=1e200)]),
        ("detector.period", 1e-12),
        ("seed", -1),
        ("time_step", 0.0),
        ("joint_period", -0.01),
        ("ground_truth_period", math.inf),
        ("mass_scale", Range(min=0.5, max=0.4)),
        ("friction", Range(min=0.0, max=0.4)),
        ("robot_friction", Range(min=0.1, max=math.inf)),
        ("hydroelastic_modulus", 0.0),
        ("mesh_resolution", 0.0),
        ("dissipation", -1.0),
        ("stiffness", [100.0, 0.0]),
        ("damping", [math.nan, 1.0]),
        ("path.end_effector", ""),
        ("path.stddev", -0.1),
        ("path.waypoints", [Waypoint()]),
        ("path.waypoints", [Waypoint(time=1.0), Waypoint(time=1.0)]),
        ("detector.period", 0.0),
        ("detector.latency", -0.1),
        ("start_stddev", PoseStddev(position=-1.0)),
        ("detector.bias_position", Range(min=-0.1, max=0.1)),
        ("detector.bias_rotation", Range(min=0.2, max=0.1)),
        ("detector.noise", PoseStddev(rotation=math.nan)),
        ("detector.hidden_visibility", 0.95),
        ("detector.hidden_visibility", -0.1),
        ("detector.outlier_chance", 1.1),
        ("detector.outlier_chance", math.nan),
        ("detector.outlier_position", Range(min=0.0, max=0.5)),
        ("detector.outlier_position", Range(min=0.7, max=0.1)),
        ("detector.outlier_rotation", Range(min=0.0, max=1.0)),
        ("detector.outlier_rotation", Range(min=1.0, max=3.2)),
    ],
)
def test_a_bad_value_is_refused_by_the_name_of_its_field(field, value):
    config = make_planar_scene().recording
    config.ValidateOrThrow()
    owner = config
    *parents, name = field.split(".")
    for parent in parents:
        owner = getattr(owner, parent)
    setattr(owner, name, value)
    with pytest.raises(ValueError, match=f"recording.{field}"):
        config.ValidateOrThrow()
