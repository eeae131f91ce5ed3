"""Where a scene's log holds what."""

import numpy as np
import pytest

from pbpf_drake.bags.ros2_messages import DETECTION_ARRAY, JOINT_STATE
from pbpf_drake.config.log_topics import LogTopics
from pbpf_drake.config.scene_config import Scene, TrackedObject
from pbpf_drake.log.log_samples import PoseSample, RawStamped
from pbpf_drake.log.log_sources import LogSources


def _sources(tracked=("box", "can"), **topics):
    return LogSources(
        Scene(
            robot="arm",
            tracked={name: TrackedObject() for name in tracked},
            topics=LogTopics(**topics),
        )
    )


def _said(*names):
    return [
        RawStamped(i, i, PoseSample("base", name, np.zeros(4), np.zeros(3)))
        for i, name in enumerate(names)
    ]


def _names(messages):
    return [m.value.name for m in messages]


def test_of_several_objects_on_one_topic_messages_say_which():
    assert _sources(detections="/seen").detections == {"/seen": None}


def test_the_only_object_is_known_and_so_is_that_of_a_topic_of_its_own():
    assert _sources(("box",), detections="/seen").detections == {"/seen": "box"}
    assert _sources(detections="/{name}/seen").detections == {
        "/box/seen": "box",
        "/can/seen": "can",
    }


def test_topics_have_their_types_and_frames_have_none():
    types = _sources(
        detections="/seen", ground_truth="tf:{name}", reference_frame="base"
    ).types
    assert list(types) == ["/joint_states", "/seen", "/tf", "/tf_static"]
    assert types["/joint_states"] == (JOINT_STATE,)
    assert DETECTION_ARRAY in types["/seen"]


def test_joints_in_tf_need_no_joint_states():
    sources = _sources(tf_joints={"a": "tip.x"}, reference_frame="base")
    assert sources.joints == ("/tf",)
    assert "/joint_states" not in sources.types


@pytest.mark.parametrize(
    "source, expected",
    [("/seen", ["", ""]), ("tf:box", ["box"]), ("/nowhere", [])],
)
def test_a_source_is_a_topic_or_a_frame_of_tf(source, expected):
    poses = {"/seen": _said("", ""), "/tf": _said("box", "can")}
    assert _names(_sources().Poses(poses, source)) == expected


def test_of_several_objects_on_one_topic_of_truth_one_is_picked():
    poses = {"/truth": _said("box", "can", "/box")}
    several = _sources(ground_truth="/truth")
    assert _names(several.Truth(poses, "box")) == ["box", "/box"]
    alone = _sources(("box",), ground_truth="/truth")
    assert _names(alone.Truth(poses, "box")) == ["box", "can", "/box"]
