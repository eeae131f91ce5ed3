import logging

import numpy as np
import pytest

from pbpf_drake.motion import motion_checks
from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.motion.motion_checks import check_motion
from pbpf_drake.motion.motion_model import MotionInput, MotionResult

POSES = np.tile([1.0, 0, 0, 0, 0.1, 0.2, 0.3], (4, 2, 1))
MOTION = MotionInput(
    poses=POSES,
    velocities=np.zeros((4, 2, 6)),
    active=np.ones(2, dtype=bool),
    path=ControlPath(np.array([0.0, 0.16]), np.zeros((2, 1))),
    estimates=POSES[:2],
    num_estimates=np.full(2, 2.0),
    step=1,
)


class MyMotion:
    """What a user might have written."""


def _result(**changes) -> MotionResult:
    arrays = {
        "poses": POSES + 1,
        "velocities": np.ones((4, 2, 6)),
        "supports": np.zeros((4, 2, 3)),
        "failed": np.zeros(4, dtype=bool),
    }
    return MotionResult(**{**arrays, **changes})


def test_a_sound_prediction_stays_as_it_is():
    result = _result()
    assert check_motion(result, MOTION, MyMotion()) is result


@pytest.mark.parametrize("name", ["poses", "velocities", "supports", "failed"])
def test_a_wrong_shape_is_named_with_the_model(name):
    result = _result(**{name: np.zeros((4, 5))})
    message = rf"MyMotion returned {name} of the shape \(4, 5\); expected \(4"
    with pytest.raises(ValueError, match=message):
        check_motion(result, MOTION, MyMotion())


@pytest.mark.parametrize("name", ["poses", "velocities", "supports"])
def test_what_is_not_finite_counts_as_failed_and_is_said_once(name, caplog):
    motion_checks._SayThatItIsNotFinite.cache_clear()
    array = getattr(_result(), name).copy()
    array[2, 1, 0] = np.nan
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            checked = check_motion(_result(**{name: array}), MOTION, MyMotion())
    np.testing.assert_array_equal(checked.failed, [False, False, True, False])
    np.testing.assert_array_equal(checked.poses[2], POSES[2])
    assert np.isfinite(getattr(checked, name)).all()
    assert caplog.text.count("MyMotion returned something") == 1
