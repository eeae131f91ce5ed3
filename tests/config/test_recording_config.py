import math

import pytest
from recording_fixtures import SCENES, make_planar_scene

from pbpf_drake.config.particle_filter_config import PoseStddev
from pbpf_drake.config.recording_config import (
    DetectorConfig,
    Range,
    RecordingConfig,
    Waypoint,
)
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


def test_a_bad_range_of_outliers_is_described_with_its_values():
    config = make_planar_scene().recording
    config.detector.outlier_position = Range(min=0.7, max=0.1)
    expected = r"outlier_position is \(0.7, 0.1\); expected 0 < min <= max"
    with pytest.raises(ValueError, match=expected):
        config.ValidateOrThrow()


def test_a_detector_may_be_without_bias_but_outliers_are_somewhere_else():
    config = make_planar_scene().recording
    config.detector.bias_position = Range()
    config.detector.bias_rotation = Range(min=0.0, max=0.1)
    config.ValidateOrThrow()
    config.detector.bias_position = Range(min=-0.1, max=0.1)
    expected = r"bias_position is \(-0.1, 0.1\); expected 0 <= min <= max"
    with pytest.raises(ValueError, match=expected):
        config.ValidateOrThrow()
    config.detector = DetectorConfig(outlier_position=Range())
    with pytest.raises(ValueError, match="outlier_position"):
        config.ValidateOrThrow()


@pytest.mark.parametrize("translation", [[0.0, 0.0], [0.0, math.nan, 0.0]])
def test_a_bad_waypoint_is_refused_by_its_index(translation):
    config = make_planar_scene().recording
    config.path.waypoints[1].translation = translation
    with pytest.raises(ValueError, match=r"waypoints\[1\].translation"):
        config.ValidateOrThrow()
