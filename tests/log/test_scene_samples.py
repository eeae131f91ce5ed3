"""What a scene asks for is read, and joints are found where they are."""

from log_fixtures import make_small_scene
from mcap_fixtures import DETECTIONS, JOINT_STATES, TRUTH
import pytest

from pbpf_drake.log.joint_plan import make_joint_plan
from pbpf_drake.log.scene_samples import ReadSceneSamples


def _read(faulty, path, names):
    faulty.__exit__()
    scene = make_small_scene()
    return ReadSceneSamples(
        path, scene, make_joint_plan(scene.topics, names, {})
    )


def test_only_topics_of_the_scene_are_read_if_they_have_all_joints(
    faulty, path
):
    faulty.joints(0.0)
    faulty.joints(0.0, names=("a", "b", "c"), topic="/other")
    found = _read(faulty, path, ("a", "b"))
    assert found.sources.joints == (JOINT_STATES,)
    assert set(found.samples.poses) == {JOINT_STATES, DETECTIONS, TRUTH}
    assert found.notes.Sentences() == ()


def test_joints_are_found_on_a_topic_that_the_scene_does_not_name(faulty, path):
    faulty.joints(0.0, names=("a",), positions=(0.0,))
    faulty.joints(0.0, names=("b",), positions=(0.0,), topic="/hand")
    faulty.joints(0.0, names=("x",), positions=(0.0,), topic="/head")
    faulty.raw(JOINT_STATES, b"", 0.1)
    found = _read(faulty, path, ("a", "b"))
    assert found.sources.joints == (JOINT_STATES, "/hand")
    assert len(found.samples.joints["/hand"]) == 1
    # What was read twice is counted once.
    assert found.samples.counts == {JOINT_STATES: 2, "/hand": 1}
    assert sorted(found.notes.Sentences()) == [
        "/hand: took from it the joints ['b'], which the topics that the "
        "scene names lack",
        "/joint_states: left out 1 message that can't be decoded",
    ]


@pytest.mark.parametrize("names", [("a", "z"), ("z",)])
def test_a_joint_that_is_nowhere_changes_nothing(faulty, path, names):
    faulty.joints(0.0, names=("a",), positions=(0.0,))
    faulty.joints(0.0, names=("x",), positions=(0.0,), topic="/head")
    found = _read(faulty, path, names)
    assert found.sources.joints == (JOINT_STATES,)
