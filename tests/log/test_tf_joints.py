"""Joints that are coordinates of tf frames."""

from framed_log_fixtures import X_WR
import numpy as np
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.bags.log_error import LogError

_TIP = {"tf_joints": {"a": "tip.y"}}


def test_joints_are_coordinates_in_the_world(tmp_path, bag):
    for i in range(5):
        bag.tf(0.1 * i, "base", "arm", RigidTransform([0, 0, 0.1 * i]))
        bag.tf(0.1 * i + 0.05, "arm", "tip", RigidTransform([0, 0.2 * i, 0]))
    joints = bag.read(tmp_path, **_TIP).joints
    # There is no sample before the tip's first one and after the arm's last.
    np.testing.assert_allclose(joints.times, np.arange(10) * 0.05)
    inside = slice(1, -1)
    p_RT = np.column_stack(
        [
            np.zeros(10),
            0.2 * (np.arange(10) - 1) / 2,
            np.zeros(10),
        ]
    )[inside]
    expected = [(X_WR @ p)[1] for p in p_RT]
    np.testing.assert_allclose(joints.positions[inside, 0], expected, atol=1e-9)


def test_a_frame_that_tf_lacks_is_named(tmp_path, bag):
    bag.tf(0.1, "base", "arm", RigidTransform())
    with pytest.raises(LogError, match="frame 'tip'.*frames are .'arm'"):
        bag.read(tmp_path, **_TIP)


def test_joints_that_the_robot_lacks_are_named(tmp_path, bag):
    bag.tf(0.1, "base", "tip", RigidTransform())
    with pytest.raises(LogError, match=r"names \['b'\]; expected .* \['a'\]"):
        bag.read(tmp_path, tf_joints={"b": "tip.y"})


def test_without_tf_the_topic_is_named(tmp_path, bag):
    with pytest.raises(LogError, match="TFMessage .*on the topic /tf"):
        bag.read(tmp_path, **_TIP)
