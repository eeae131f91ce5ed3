import logging

import numpy as np
import pytest

from pbpf_drake.filtering.input_warnings import InputWarnings
from pbpf_drake.filtering.recent_detections import DETECTION_FATES

NONE_REJECTED = np.zeros(1)


def _counts(**fates: int) -> np.ndarray:
    names = [name.replace(" ", "_").split(",")[0] for name in DETECTION_FATES]
    return np.array([[fates.get(name, 0) for name in names]], dtype=float)


@pytest.fixture
def dut(caplog):
    caplog.set_level(logging.WARNING)
    return InputWarnings(["box"], ["axis_1", "axis_2"])


@pytest.mark.parametrize("fate", ["too_old", "of_the_future", "not_finite"])
def test_what_is_mostly_left_out_is_said_once_with_a_remedy(fate, dut, caplog):
    for count in range(1, 30):
        counts = _counts(used=2, **{fate: count})
        dut.CheckDetections(counts, NONE_REJECTED)
    (record,) = caplog.records
    assert "box: 4 of 6 detections were not used" in record.message
    assert fate.replace("_", " ") in record.message
    assert len(record.message.split(";")) == 2


def test_a_few_are_not_worth_a_word(dut, caplog):
    dut.CheckDetections(_counts(too_old=3), NONE_REJECTED)
    dut.CheckDetections(_counts(used=900, too_old=90), NONE_REJECTED)
    assert caplog.text == ""


def test_a_track_that_rejects_everything_is_said_once_per_time(dut, caplog):
    for streak in range(2):
        for count in range(20):
            dut.CheckDetections(_counts(used=9), np.array([float(count)]))
        assert caplog.text.count("far from all particles") == streak + 1


def test_joints_without_a_position_are_named_once(dut, caplog):
    for _ in range(3):
        dut.CheckJoints(np.array([0.1, np.nan]))
    assert caplog.text.count("['axis_2'] have no finite position") == 1
    dut.CheckJoints(np.zeros(2))
    assert len(caplog.records) == 1
