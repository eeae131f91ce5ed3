import pytest
from recording_fixtures import make_planar_scene

from pbpf_drake.config.detector_config import DetectorConfig
from pbpf_drake.config.distributions import Range


def test_default_detectors_can_be_used():
    DetectorConfig().ValidateOrThrow("detector")


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
