"""Joints are found on topics that the scene doesn't name."""

import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.log.joint_topics import joint_topics


def test_every_joint_is_found_where_it_is():
    topics = {"/hand": ["f1", "f2", "x"], "/base": ["wheel"], "/head": ["pan"]}
    assert joint_topics(["f2", "wheel", "f1", "lost"], topics) == {
        "/hand": ["f2", "f1"],
        "/base": ["wheel"],
    }


def test_a_joint_on_several_topics_is_refused_with_their_names():
    topics = {"/left": ["f"], "/right": ["f"]}
    with pytest.raises(LogError, match="'f' .* on /left and /right: name the"):
        joint_topics(["f"], topics)
