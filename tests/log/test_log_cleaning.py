"""Faults of single messages, from the file to the log."""

import math

from log_fixtures import make_small_scene
from mcap_fixtures import DETECTIONS, JOINT_STATES, SECOND, T0, FaultyLog
import numpy as np
import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.poses.quaternions import angle_between


@pytest.fixture
def path(tmp_path):
    return tmp_path / "log.mcap"


@pytest.fixture
def faulty(path):
    with FaultyLog(path) as log:
        yield log


def _read(path, log, names=("a", "b")):
    log.__exit__()
    return ReadLog(filename=path, scene=make_small_scene(), joint_names=names)


def _has(log, *parts):
    """Whether one warning has all parts."""
    return any(all(p in w for p in parts) for w in log.warnings)


def test_joint_states_with_a_wrong_count_are_left_out(path, faulty):
    faulty.joints(0.0)
    faulty.joints(0.1, positions=(1.0, 2.0, 3.0))
    faulty.joints(0.2, positions=(7.0, 8.0))
    log = _read(path, faulty)
    assert log.joints.times.tolist() == [0.0, 0.2]
    assert _has(log, JOINT_STATES, "1 message", "3 values for 2 names")


def test_a_log_with_only_wrong_counts_is_refused(path, faulty):
    for i in range(3):
        faulty.joints(0.1 * i, positions=(1.0,))
    with pytest.raises(
        LogError, match="/joint_states: left out 3 .* 1 values for 2 names"
    ):
        _read(path, faulty)


def test_unknown_joint_names_are_refused_with_those_that_are_there(
    path, faulty
):
    faulty.joints(0.0)
    with pytest.raises(
        LogError, match=r"without the joints \['c'\].* \('a', 'b'\)"
    ):
        _read(path, faulty, names=("b", "c"))


def test_messages_of_other_joints_are_left_out(path, faulty):
    faulty.joints(0.0)
    faulty.joints(0.05, names=("g",), positions=(0.5,))
    faulty.joints(0.1)
    log = _read(path, faulty)
    assert len(log.joints.times) == 2
    assert _has(log, "1 message without the joints ['a', 'b']")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_joints_that_are_not_finite_are_left_out(path, faulty, value):
    faulty.joints(0.0, positions=(value, 0.0))
    faulty.joints(0.1, positions=(0.3, 0.4))
    faulty.joints(0.2, positions=(0.0, value))
    log = _read(path, faulty)
    # The log starts where it can be used.
    assert log.joints.times.tolist() == [0.0]
    assert log.start_time == T0 + SECOND // 10
    assert log.joints.positions.tolist() == [[0.3, 0.4]]
    assert _has(log, "left out 2 messages", "position is not finite")


def test_a_log_of_only_nan_joints_is_refused(path, faulty):
    faulty.joints(0.0, positions=(math.nan, 0.0))
    with pytest.raises(LogError, match="1 message .* is not finite"):
        _read(path, faulty)


def test_a_joint_that_is_not_the_robots_may_be_nan(path, faulty):
    faulty.joints(0.0, names=("a", "b", "c"), positions=(1, 2, math.nan))
    log = _read(path, faulty)
    assert log.joints.positions.tolist() == [[1.0, 2.0]]


def test_stamps_are_sorted_and_duplicates_left_out(path, faulty):
    for i, time in enumerate([0.0, 0.2, 0.1, 0.3, 0.2]):
        stamp = T0 + round(time * SECOND)
        faulty.joints(0.1 * i, positions=(i, 0), stamp=stamp)
    log = _read(path, faulty)
    assert log.joints.times.tolist() == [0.0, 0.1, 0.2, 0.3]
    assert log.joints.positions[:, 0].tolist() == [0, 2, 1, 3]
    assert _has(log, "put in order 2 messages")
    assert _has(log, "left out 1 message with the stamp of an earlier one")


@pytest.mark.parametrize("second", [[math.nan, 2.0], [1.0], []])
def test_velocities_are_used_only_if_all_are_whole(path, faulty, second):
    faulty.joints(0.0, velocity=[1.0, 2.0])
    faulty.joints(0.1, velocity=second)
    assert _read(path, faulty).joints.velocities is None


def test_a_log_without_detections_is_read_and_says_so(path, faulty):
    faulty.joints(0.0)
    log = _read(path, faulty)
    assert log.detections == ()
    assert _has(log, "no detections of ['box']", DETECTIONS, "nominal poses")


@pytest.mark.parametrize(
    "fault, reason",
    [
        ({"q": (0, 0, 0, 0)}, "quaternion is zero"),
        ({"q": (1e-7, 0, 0, 0)}, "quaternion is zero"),
        ({"q": (math.nan, 0, 0, 1)}, "quaternion is not finite"),
        ({"q": (math.inf, 0, 0, 1)}, "quaternion is not finite"),
        ({"p": (math.nan, 0, 0)}, "position is not finite"),
        ({"p": (0, 0, math.inf)}, "position is not finite"),
        ({"name": "mug"}, "unknown class 'mug'"),
    ],
)
def test_a_bad_detection_is_left_out(path, faulty, fault, reason):
    faulty.joints(0.0)
    faulty.detection(0.1)
    faulty.detection(0.2, **fault)
    faulty.detection(0.3, **fault)
    log = _read(path, faulty)
    assert [d.time for d in log.detections] == [0.1]
    assert _has(log, DETECTIONS, "left out 2 detections", reason)
    assert len(log.warnings) == 1


@pytest.mark.parametrize("length, warned", [(1.05, 0), (0.95, 0), (3.0, 1)])
def test_a_quaternion_is_normalized(path, faulty, length, warned):
    q = length * np.array([0.5, -0.5, 0.5, 0.5])
    faulty.joints(0.0)
    faulty.detection(0.1, q=q)
    faulty.truth(0.1, q=q)
    log = _read(path, faulty)
    expected = np.array([0.5, -0.5, 0.5, 0.5])
    found = log.detections[0].X_CO.rotation().ToQuaternion().wxyz()
    assert angle_between(found, expected) < 1e-14
    np.testing.assert_allclose(
        log.ground_truth["box"].q_WO[0], expected, atol=1e-15
    )
    assert len(log.warnings) == 2 * warned


def test_bad_ground_truth_is_left_out(path, faulty):
    faulty.joints(0.0)
    faulty.detection(0.0)
    faulty.truth(0.1, q=(0, 0, 0, 0))
    faulty.truth(0.3, p=(3, 0, 0))
    faulty.truth(0.5, p=(2, 0, 0), stamp=T0 + SECOND // 5)
    faulty.truth(0.6, p=(math.nan, 0, 0))
    faulty.truth(0.7, p=(4, 0, 0), stamp=T0 + 3 * SECOND // 10)
    log = _read(path, faulty)
    truth = log.ground_truth["box"]
    assert truth.times.tolist() == [0.2, 0.3]
    assert truth.p_WO[:, 0].tolist() == [2.0, 3.0]
    assert len(log.warnings) == 4
