"""Statistics of a detector's errors."""

from detector_fixtures import error_series
import numpy as np
import pytest

from pbpf_drake.config.detector_config import DetectorConfig
from pbpf_drake.diagrams.detector.error_statistics import (
    describe_errors,
    describe_images,
    is_stale,
)


def test_only_what_drifts_after_the_first_jump_is_stale():
    np.testing.assert_array_equal(np.flatnonzero(is_stale(error_series())),
                                  np.arange(44, 80))  # fmt: skip
    assert not is_stale(error_series()[:40]).any()


def test_statistics_are_those_of_theerror_series():
    found = describe_errors(error_series())
    assert found["stale share"] == pytest.approx(36 / 80)
    assert found["position: outliers' median"] == pytest.approx(0.35)
    assert found["rotation: outliers' median"] == pytest.approx(2.0)
    assert found["position: share of outliers"] == pytest.approx(2 / 80)
    assert found["rotation: share of outliers"] == pytest.approx(3 / 80)
    assert found["position: last"] == pytest.approx(0.472)
    # The difference of two independent numbers.
    assert found["position: step noise"] == pytest.approx(2.8e-3, rel=0.3)


def test_every_image_is_clear_or_partly_hidden_or_hidden():
    config = DetectorConfig(hidden_visibility=0.5, clear_visibility=0.9)
    visibility = np.array([1.0, 0.9, 0.89, 0.5, 0.49, 0.2, 0.1, 0.0])
    found = describe_images(visibility, config)
    assert found == {
        "images: clear": 2 / 8,
        "images: partly hidden": 2 / 8,
        "images: hidden": 4 / 8,
    }
