"""Recorded pushes with two fingers as logs."""

from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
import pytest

from pbpf_drake.diagrams.recorded_pushes.two_finger_log import (
    JOINT_NAMES,
    ReadTwoFingerPush,
    cut_to_update,
    find_dropouts,
    lift_in_pauses,
    was_lifted,
)
from pbpf_drake.log.log_records import Log

X_WC = RigidTransform(RollPitchYaw(np.pi, 0.0, 0.0), [0.0, -0.32, 1.0])
_TITLES = "t,obj_x,obj_y,obj_theta,pusher_x,pusher_y,pusher_theta,detected"
_ROWS = [
    "5.00,0.01,-0.30,1.5,0.04,-0.35,3.1,1",
    "5.03,0.00,0.00,0.0,0.03,-0.35,-3.1,0",
    "5.30,0.02,-0.31,1.4,0.02,-0.35,-3.1,1",
    "8.30,0.02,-0.31,1.4,0.05,-0.30,0.4,1",
    "8.33,0.02,-0.31,1.4,0.06,-0.30,0.4,1",
]


def _read(folder: Path, titles: str = _TITLES, rows: list = _ROWS) -> Log:
    path = folder / "push.csv"
    path.write_text("\n".join([titles, *rows]) + "\n")
    return ReadTwoFingerPush(path, X_WC=X_WC, height=0.0065)


def test_what_the_camera_lost_is_no_detection(tmp_path):
    log = _read(tmp_path)
    times = [d.time for d in log.detections]
    np.testing.assert_allclose(times, [0.0, 0.3, 3.3, 3.33])
    np.testing.assert_allclose(log.ground_truth["block"].times, times)
    X_WO = X_WC @ log.detections[1].X_CO
    np.testing.assert_allclose(X_WO.translation(), [0.02, -0.31, 0.0065])
    turn = RollPitchYaw(X_WO.rotation()).vector()
    np.testing.assert_allclose(turn, [0, 0, 1.4], atol=1e-12)


def test_fingers_are_lifted_within_pauses_only(tmp_path):
    joints = _read(tmp_path).joints
    assert np.all(np.diff(joints.times) > 0)
    z = joints.positions[:, JOINT_NAMES.index("pusher_z")]
    up = joints.times[z > 0]
    assert len(up) == 2 and np.all((up > 0.3) & (up < 3.3))
    x, y = joints.positions[z > 0, :2].T
    # They are lifted where they were, and lowered where they are then.
    np.testing.assert_allclose([x[0], y[0]], [0.02, -0.35])
    np.testing.assert_allclose([x[1], y[1]], [0.05, -0.30])
    assert was_lifted(joints, 0.3, 3.3)
    assert not was_lifted(joints, 0.0, 0.3)
    assert not was_lifted(joints, 3.3, 3.33)


def test_fingers_do_not_turn_around_where_their_angle_jumps():
    theta = np.array([3.1, -3.1, -3.0])
    positions = np.column_stack([0 * theta, 0 * theta, theta])
    joints = lift_in_pauses(np.array([0.0, 0.1, 0.2]), positions)
    turned = np.diff(joints.positions[:, 3])
    np.testing.assert_allclose(turned, [2 * np.pi - 6.2, 0.1])


def test_dropouts_are_between_detections_that_are_far_apart():
    times = np.array([0.0, 0.1, 0.2, 0.5, 0.6, 2.0])
    np.testing.assert_array_equal(
        find_dropouts(times, 0.2), [[0.2, 0.5], [0.6, 2.0]]
    )
    assert find_dropouts(times, 2.0).shape == (0, 2)


@pytest.mark.parametrize("time", [0.3, 0.32, 3.3])
def test_last_update_of_a_log_that_is_cut_is_at_that_time(tmp_path, time):
    period, log = 0.16, _read(tmp_path)
    dut = cut_to_update(log, time, period)
    updates = int(dut.duration / period + 1e-9)
    start = time - updates * period
    assert 0 <= start < period
    # Nothing that is detected then, or later, or before the cut.
    kept = [d.time for d in log.detections if start <= d.time < time]
    np.testing.assert_allclose([d.time + start for d in dut.detections], kept)
    assert dut.joints.times[0] == 0
    assert dut.duration == pytest.approx(updates * period + period / 2)
    for name in range(4):
        np.testing.assert_allclose(
            np.interp(0.2, dut.joints.times, dut.joints.positions[:, name]),
            np.interp(
                0.2 + start, log.joints.times, log.joints.positions[:, name]
            ),
        )


@pytest.mark.parametrize("name", _TITLES.split(","))
def test_a_missing_column_is_named(tmp_path, name):
    titles = ["other" if t == name else t for t in _TITLES.split(",")]
    with pytest.raises(ValueError, match=rf"no columns \['{name}'\]"):
        _read(tmp_path, titles=",".join(titles))
