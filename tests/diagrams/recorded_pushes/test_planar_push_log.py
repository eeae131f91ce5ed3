import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
import pytest

from pbpf_drake.diagrams.recorded_pushes.planar_push_log import ReadPlanarPush
from pbpf_drake.poses import quaternions
from pbpf_drake.poses.pose_conversion import pose_array

NAMES = "t,slider_x,slider_y,slider_theta,pusher_x,pusher_y,new_pose"
X_WC = RigidTransform(RollPitchYaw(np.pi, 0.1, 0.2), [0.4, -0.1, 1.0])
HEIGHT = 0.0065
START, RATE, DURATION = 12.5, 250, 8.0


def _rows() -> np.ndarray:
    """A recording: the pose is a new sample at every other row."""
    t = START + np.arange(round(RATE * DURATION) + 1) / RATE
    s = t - START
    new = (np.arange(len(t)) % 2).astype(float)
    return np.column_stack(
        [t, 0.2 + 0.02 * s, 0.01 * s, 0.1 * s, 0.15 + 0.02 * s, 0 * s, new]
    )


def _write(path, rows, names=NAMES):
    np.savetxt(path, rows, delimiter=",", header=names, comments="")
    return path


@pytest.fixture(scope="module")
def push(tmp_path_factory):
    return _write(tmp_path_factory.mktemp("push") / "push.csv", _rows())


def _read(path, **changes):
    arguments = {"seed": 0, "X_WC": X_WC, "height": HEIGHT, **changes}
    return ReadPlanarPush(path, **arguments)


def test_joints_are_the_sensed_probe_since_the_start(push):
    joints, rows = _read(push).joints, _rows()
    assert joints.names == ("pusher_x", "pusher_y")
    np.testing.assert_allclose(joints.times, rows[:, 0] - START, atol=1e-9)
    np.testing.assert_allclose(joints.positions, rows[:, 4:6])
    assert joints.velocities is None


def test_truth_has_the_new_samples_and_the_first(push):
    log, rows = _read(push, object_name="brick"), _rows()
    assert list(log.ground_truth) == ["brick"]
    truth = log.ground_truth["brick"]
    new = rows[:, 6] > 0
    new[0] = True
    np.testing.assert_allclose(truth.times, rows[new, 0] - START, atol=1e-9)
    np.testing.assert_allclose(truth.p_WO[:, :2], rows[new, 1:3])
    np.testing.assert_array_equal(truth.p_WO[:, 2], HEIGHT)
    turn = quaternions.to_rotation_vector(truth.q_WO)
    np.testing.assert_allclose(turn[:, 2], rows[new, 3], atol=1e-12)
    np.testing.assert_allclose(turn[:, :2], 0, atol=1e-15)


def test_detections_come_at_15_hz_and_not_in_the_blackout(push):
    log = _read(push)
    times = np.array([d.time for d in log.detections])
    expected = np.arange(0, DURATION, 1 / 15)
    hidden = (expected >= 0.4 * DURATION) & (expected <= 0.8 * DURATION)
    assert np.mean(hidden) == pytest.approx(0.4, abs=0.01)
    np.testing.assert_allclose(times, expected[~hidden], atol=1e-9)
    assert all(d.received == d.time for d in log.detections)
    assert {d.name for d in log.detections} == {"block"}


def test_the_blackout_can_be_elsewhere(push):
    log = _read(push, blackout=(0.1, 0.2))
    times = np.array([d.time for d in log.detections]) / DURATION
    assert np.any(times < 0.1) and np.any(times > 0.2)
    assert not np.any((times > 0.1) & (times < 0.2))


def test_errors_of_detections_are_as_documented(push):
    """0.02 m along each axis, 0.09 rad about each."""
    shifts, turns = [], []
    for seed in range(12):
        for detection in _read(push, seed=seed).detections:
            pose = pose_array(X_WC @ detection.X_CO)
            s = detection.time
            shifts.append(pose[4:] - [0.2 + 0.02 * s, 0.01 * s, HEIGHT])
            true = quaternions.from_rotation_vector([0, 0, 0.1 * s])
            turn = quaternions.multiply(pose[:4], quaternions.conjugate(true))
            turns.append(quaternions.to_rotation_vector(turn))
    count = len(shifts)
    for errors, stddev in ((np.array(shifts), 0.02), (np.array(turns), 0.09)):
        np.testing.assert_allclose(
            np.mean(errors, axis=0), 0, atol=4 * stddev / np.sqrt(count)
        )
        np.testing.assert_allclose(
            np.cov(errors.T), stddev**2 * np.eye(3), atol=0.15 * stddev**2
        )


def _poses(log):
    return np.array([d.X_CO.GetAsMatrix34() for d in log.detections])


def test_the_seed_decides_on_the_errors_and_on_nothing_else(push):
    first, again, other = (_read(push, seed=s) for s in (3, 3, 4))
    np.testing.assert_array_equal(_poses(first), _poses(again))
    assert not np.any(_poses(first)[:, :, 3] == _poses(other)[:, :, 3])
    np.testing.assert_array_equal(
        first.joints.positions, other.joints.positions
    )


def test_nothing_is_detected_after_the_last_pose_that_is_known(tmp_path):
    rows = _rows()
    rows[rows[:, 0] > START + 7, 6] = 0
    log = _read(_write(tmp_path / "push.csv", rows))
    assert max(d.time for d in log.detections) < 7
    assert log.duration == pytest.approx(DURATION)


@pytest.mark.parametrize("name", NAMES.split(","))
def test_a_missing_column_is_named(tmp_path, name):
    names = NAMES.replace(name, "something")
    path = _write(tmp_path / "push.csv", _rows(), names)
    with pytest.raises(ValueError, match=rf"push\.csv has no .*'{name}'"):
        _read(path)
