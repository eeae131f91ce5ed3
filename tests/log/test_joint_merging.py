"""The robot's motion is put together from all messages that say some of it."""

from log_fixtures import has_warning, make_small_scene
from mcap_fixtures import JOINT_STATES, SECOND, T0
import numpy as np
import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.model_facts import MimicJoint, ModelFacts

GRIPPER = "/gripper/joint_states"


def _scene(**topics):
    scene = make_small_scene()
    for name, value in topics.items():
        setattr(scene.topics, name, value)
    return scene


def test_joints_in_two_messages_on_one_topic_are_merged(faulty):
    for i in range(5):
        faulty.joints(0.1 * i, names=("a",), positions=(0.1 * i,))
        faulty.joints(0.1 * i + 0.003, names=("b",), positions=(-0.1 * i,))
    log = faulty.read()
    # There is a sample whenever a joint was measured, of all joints.
    times = sorted(
        [0.1 * i for i in range(5)] + [0.1 * i + 0.003 for i in range(5)]
    )
    np.testing.assert_allclose(log.joints.times, times, atol=1e-9)
    q_b = np.maximum(log.joints.times - 0.003, 0.0)
    expected = np.column_stack([np.minimum(log.joints.times, 0.4), -q_b])
    np.testing.assert_allclose(log.joints.positions, expected, atol=1e-9)
    assert not has_warning(log, "joint")


@pytest.mark.parametrize("named", [True, False])
def test_a_joint_on_a_topic_of_its_own_at_its_own_rate_is_found(faulty, named):
    for i in range(11):
        faulty.joints(0.1 * i, names=("a",), positions=(0.1 * i,))
    for i in range(3):
        faulty.joints(
            0.5 * i, names=("b",), positions=(0.5 * i,), topic=GRIPPER
        )
    log = faulty.read(_scene(more_joint_states=[GRIPPER]) if named else None)
    times = 0.1 * np.arange(11)
    np.testing.assert_allclose(log.joints.times, times)
    np.testing.assert_allclose(
        log.joints.positions, np.column_stack([times, times])
    )
    # What the scene doesn't name is said.
    assert named != has_warning(log, GRIPPER, "took from it the joints ['b']")


def test_a_joint_on_two_topics_that_nobody_named_is_refused(faulty):
    faulty.joints(0.0, names=("a",), positions=(0.0,))
    for topic in ("/left", "/right"):
        faulty.joints(0.0, names=("b",), positions=(0.0,), topic=topic)
    with pytest.raises(
        LogError,
        match="joint 'b' is not on .* but on /left and /right: name the right "
        "one in topics.more_joint_states",
    ):
        faulty.read()


def test_messages_of_all_joints_and_of_some_go_together(faulty):
    for i in range(4):
        faulty.joints(0.1 * i, positions=(0.1 * i, 0.2 * i))
    for i in range(4, 8):
        faulty.joints(0.1 * i, names=("b",), positions=(0.2 * i,))
        faulty.joints(0.1 * i, names=("a",), positions=(0.1 * i,))
    log = faulty.read()
    times = 0.1 * np.arange(8)
    np.testing.assert_allclose(
        log.joints.positions, np.column_stack([times, 2 * times]), atol=1e-12
    )


def test_a_joint_is_held_where_it_is_not_known_and_that_is_said(faulty):
    for i in range(11):
        faulty.joints(0.1 * i, names=("a",), positions=(0.0,))
    for time, position in ((0.4, 1.0), (0.5, 2.0)):
        faulty.joints(time, names=("b",), positions=(position,))
    log = faulty.read()
    assert log.joints.positions[:, 1].tolist() == [1.0] * 5 + [2.0] * 6
    assert has_warning(log, "'b' is held for 0.40 s before its first message")
    assert has_warning(log, "'b' is held for 0.50 s after its last message")


@pytest.mark.parametrize("velocities", [True, False])
def test_velocities_are_merged_if_every_joint_has_them(faulty, velocities):
    for i in range(3):
        faulty.joints(0.1 * i, names=("a",), positions=(0.0,), velocity=[0.5])
        faulty.joints(
            0.1 * i,
            names=("b",),
            positions=(0.0,),
            velocity=[0.1 * i] if velocities else [],
        )
    found = faulty.read().joints.velocities
    if velocities:
        expected = [[0.5, 0.0], [0.5, 0.1], [0.5, 0.2]]
        np.testing.assert_allclose(found, expected)
    else:
        assert found is None


def test_a_mimic_joint_that_no_message_has_follows_its_leader(faulty):
    for i in range(3):
        faulty.joints(
            0.1 * i, names=("a",), positions=(0.2 * i,), velocity=[2.0]
        )
    mimics = {
        "c": MimicJoint("b", multiplier=1.0, offset=0.5),
        "b": MimicJoint("a", multiplier=-2.0),
    }
    log = faulty.read(
        joint_names=("c", "b", "a"), facts=ModelFacts(mimics=mimics)
    )
    q = 0.2 * np.arange(3)
    np.testing.assert_allclose(
        log.joints.positions, np.column_stack([0.5 - 2 * q, -2 * q, q])
    )
    np.testing.assert_allclose(log.joints.velocities, [[-4.0, -4.0, 2.0]] * 3)
    assert has_warning(log, "no message has the joint 'b': it follows 'a'")


def test_a_mimic_joint_that_is_logged_is_what_the_log_says(faulty):
    faulty.joints(0.0, positions=(0.1, 0.3))
    facts = ModelFacts(mimics={"b": MimicJoint("a")})
    assert faulty.read(facts=facts).joints.positions.tolist() == [[0.1, 0.3]]


def test_a_fixed_joint_is_where_the_scene_says(faulty):
    faulty.joints(0.0, names=("a",), positions=(0.1,), velocity=[1.0])
    log = faulty.read(_scene(fixed_joints={"b": 0.7}))
    assert log.joints.positions.tolist() == [[0.1, 0.7]]
    assert log.joints.velocities.tolist() == [[1.0, 0.0]]


def test_a_fixed_joint_goes_before_what_the_log_says_of_it(faulty):
    faulty.joints(0.0, positions=(0.1, float("nan")))
    log = faulty.read(_scene(fixed_joints={"b": 0.7}))
    assert log.joints.positions.tolist() == [[0.1, 0.7]]


def test_a_joint_that_is_nowhere_is_named_with_all_remedies(faulty):
    faulty.joints(0.0, names=("a",), positions=(0.1,))
    with pytest.raises(LogError) as error:
        faulty.read()
    for part in (
        "without the joints ['b']; it has ('a',)",
        "topics.more_joint_states",
        "topics.joint_names",
        "topics.fixed_joints",
    ):
        assert part in str(error.value)


@pytest.mark.parametrize("field", ["joint_names", "fixed_joints"])
def test_a_joint_that_the_robot_lacks_is_refused(faulty, field):
    faulty.joints(0.0)
    value = {"elbow": "a" if field == "joint_names" else 0.0}
    with pytest.raises(LogError, match=rf"{field} names \['elbow'\], which"):
        faulty.read(_scene(**{field: value}))


def test_a_joint_that_is_never_finite_is_named(faulty):
    for i in range(3):
        faulty.joints(0.1 * i, positions=(0.0, float("nan")))
    with pytest.raises(LogError, match="joint 'b' is not finite 3 times"):
        faulty.read()


def test_a_gap_is_said_with_its_length_and_place(faulty):
    for i in range(60):
        if not 20 < i < 50:
            faulty.joints(0.1 * i)
    log = faulty.read()
    assert has_warning(
        log, JOINT_STATES, "1 gap without", "longest of 3.00 s from 2.00 s on"
    )


def test_a_joint_that_jumps_and_comes_back_is_named(faulty):
    for i in range(20):
        q = 0.01 * i
        faulty.joints(0.1 * i, positions=(q, q + (0.5 if i == 7 else 0.0)))
    log = faulty.read()
    assert has_warning(log, "'b' jumps and comes back", "1 time", "at 0.700 s")
    # It may be true: it is used.
    assert log.joints.positions[7, 1] == pytest.approx(0.57)


def test_a_joint_that_can_only_be_damaged_is_named(faulty):
    for i in range(20):
        faulty.joints(0.01 * i, positions=(0.0, 9.0 if i == 7 else 0.0))
    log = faulty.read()
    assert has_warning(log, "left out 1 message whose joint 'b' is too far")


def test_the_start_is_the_first_sample_of_any_joint(faulty):
    faulty.joints(0.3, names=("b",), positions=(0.0,))
    faulty.joints(0.5, names=("a",), positions=(0.0,))
    log = faulty.read()
    assert log.start_time == T0 + round(0.3 * SECOND)
    assert log.joints.times.tolist() == [0.0, 0.2]


def test_a_gripper_that_is_never_finite_is_named_with_the_remedy(faulty):
    faulty.joints(0.0, names=("a",), positions=(0.0,))
    faulty.joints(0.0, names=("b",), positions=(float("nan"),))
    with pytest.raises(LogError) as error:
        faulty.read()
    for part in (
        "no message that can be used has the joints ['b']",
        "the joint 'b' is not finite 1 time; if nobody measures it",
        "topics.fixed_joints",
    ):
        assert part in str(error.value)
