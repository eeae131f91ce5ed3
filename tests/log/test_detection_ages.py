"""Detections that come too late, or from a clock that is ahead, are told."""

from log_fixtures import has_warning, make_small_scene
import numpy as np
import pytest

from pbpf_drake.log.detection_ages import (
    age_summary,
    age_warning,
    ahead_warning,
)


def _warn(delay, max_age=0.25):
    times = np.arange(40) / 15
    return age_warning(times, times + delay, period=0.16, max_age=max_age)


def test_ages_are_summed_up():
    ages = np.concatenate([np.full(90, 0.2), np.full(10, 0.9)])
    assert age_summary(ages).startswith("0.200 s old when they arrive")
    assert "95th percentile 0.900 s" in age_summary(ages)


@pytest.mark.parametrize("delay", [0.0, 0.03, 0.15])
def test_detections_that_are_in_time_are_no_problem(delay):
    assert _warn(delay) == ""


@pytest.mark.parametrize("delay", [0.26, 1.7, 30.0])
def test_a_slow_detector_is_told_with_the_remedy(delay):
    said = _warn(delay)
    count = said.split()[1]
    assert said.startswith(f"at {count} of {count} updates")
    for part in (
        "filter.max_detection_age, 0.25 s",
        f"{delay:.3f} s old",
        "raise filter.max_detection_age, or correct the stamps",
    ):
        assert part in said


def test_only_the_newest_detection_of_an_update_counts():
    # The one at 0.02 s is old at the update at 0.16 s, but it isn't used.
    times, received = np.array([0.02, 0.15]), np.array([0.03, 0.155])
    late = {"period": 0.16, "max_age": 0.1}
    assert age_warning(times, received, **late) == ""
    assert age_warning(times[:1], received[:1], **late) != ""


def test_a_clock_that_is_ahead_is_told():
    assert ahead_warning(np.array([0.0, -0.03, 0.005])) == ""
    said = ahead_warning(np.array([0.5, 0.5, 0.5, -0.03]))
    assert "3 of 4" in said and "0.500 s" in said and "ahead" in said


@pytest.mark.parametrize(
    ("delay", "part"), [(2.5, "older than filter.max"), (-0.5, "is ahead")]
)
def test_a_log_says_when_detections_come_at_the_wrong_time(faulty, delay, part):
    for i in range(30):
        faulty.joints(0.1 * i)
        faulty.detection(0.1 * i, delay=delay)
    assert has_warning(faulty.read(make_small_scene()), "'box'", part)
