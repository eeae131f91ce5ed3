"""Joint states that can't be used are left out and counted."""

import math

from log_fixtures import has_warning
from mcap_fixtures import JOINT_STATES, SECOND, T0
import pytest

from pbpf_drake.bags.log_error import LogError


def test_joint_states_with_a_wrong_count_are_left_out(faulty):
    faulty.joints(0.0)
    faulty.joints(0.1, positions=(1.0, 2.0, 3.0))
    faulty.joints(0.2, positions=(7.0, 8.0))
    log = faulty.read()
    assert log.joints.times.tolist() == [0.0, 0.2]
    assert has_warning(log, JOINT_STATES, "1 message", "3 values for 2 names")


def test_a_log_with_only_wrong_counts_is_refused(faulty):
    for i in range(3):
        faulty.joints(0.1 * i, positions=(1.0,))
    with pytest.raises(
        LogError, match="/joint_states: left out 3 .* 1 values for 2 names"
    ):
        faulty.read()


def test_unknown_joint_names_are_refused_with_those_that_are_there(faulty):
    faulty.joints(0.0)
    with pytest.raises(
        LogError, match=r"without the joints \['c'\].* \('a', 'b'\)"
    ):
        faulty.read(joint_names=("b", "c"))


def test_messages_of_other_joints_are_left_out(faulty):
    faulty.joints(0.0)
    faulty.joints(0.05, names=("g",), positions=(0.5,))
    faulty.joints(0.1)
    log = faulty.read()
    assert len(log.joints.times) == 2
    assert has_warning(log, "1 message without the joints ['a', 'b']")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_joints_that_are_not_finite_are_left_out(faulty, value):
    faulty.joints(0.0, positions=(value, 0.0))
    faulty.joints(0.1, positions=(0.3, 0.4))
    faulty.joints(0.2, positions=(0.0, value))
    log = faulty.read()
    # The log starts where it can be used.
    assert log.joints.times.tolist() == [0.0]
    assert log.start_time == T0 + SECOND // 10
    assert log.joints.positions.tolist() == [[0.3, 0.4]]
    assert has_warning(log, "left out 2 messages", "position is not finite")


def test_a_log_of_only_nan_joints_is_refused(faulty):
    faulty.joints(0.0, positions=(math.nan, 0.0))
    with pytest.raises(LogError, match="1 message .* is not finite"):
        faulty.read()


def test_a_joint_that_is_not_the_robots_may_be_nan(faulty):
    faulty.joints(0.0, names=("a", "b", "c"), positions=(1, 2, math.nan))
    log = faulty.read()
    assert log.joints.positions.tolist() == [[1.0, 2.0]]


@pytest.mark.parametrize("second", [[math.nan, 2.0], [1.0], []])
def test_velocities_are_used_only_if_all_are_whole(faulty, second):
    faulty.joints(0.0, velocity=[1.0, 2.0])
    faulty.joints(0.1, velocity=second)
    assert faulty.read().joints.velocities is None
