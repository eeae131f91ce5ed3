"""It is known where the motion of each joint comes from."""

import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.config.log_topics import LogTopics
from pbpf_drake.log.joint_plan import (
    make_joint_plan,
    missing_joints,
    unlogged_joints,
)
from pbpf_drake.model_facts import MimicJoint

_TOPICS = LogTopics(joint_names={"a": "axis"}, fixed_joints={"c": 1.0})
_MIMICS = {"d": MimicJoint("a")}


def test_fixed_joints_are_not_logged_and_others_have_their_names_in_the_log():
    plan = make_joint_plan(_TOPICS, ["a", "b", "c", "d"], _MIMICS)
    assert plan.logged == {"a": "axis", "b": "b", "d": "d"}
    assert plan.fixed == {"c": 1.0} and plan.mimics == _MIMICS


def test_coordinates_of_frames_have_the_names_of_the_model():
    topics = LogTopics(joint_names={"a": "axis"}, tf_joints={"a": "tip.x"})
    assert make_joint_plan(topics, ["a"], {}).logged == {"a": "a"}


def test_what_is_to_be_found_is_neither_there_nor_fixed_nor_a_mimic_joint():
    plan = make_joint_plan(_TOPICS, ["a", "b", "c", "d"], _MIMICS)
    assert unlogged_joints(plan, []) == ["axis", "b"]
    assert unlogged_joints(plan, ["axis", "x"]) == ["b"]


@pytest.mark.parametrize("field", ["joint_names", "fixed_joints"])
def test_a_joint_that_the_robot_lacks_is_refused(field):
    joints = ["a"] if field == "fixed_joints" else ["c"]
    with pytest.raises(LogError, match=rf"topics\.{field} names .*{joints}"):
        make_joint_plan(_TOPICS, joints, {})


def test_missing_joints_are_named_with_every_remedy():
    said = missing_joints(["b"], ("a",))
    for part in (
        "['b']", "('a',)", "more_joint_states", "joint_names", "fixed_joints",
    ):  # fmt: skip
        assert part in said
