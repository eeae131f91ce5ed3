"""Frames that move are resolved at the time that is asked for."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.log_samples import PoseSample, Stamped
from pbpf_drake.log.transform_tree import make_transform_tree
from pbpf_drake.poses.pose_conversion import pose_array, rigid_transform

SECOND = 10**9
# A time of a real clock (in nanoseconds).
T0 = 1_700_000_000 * SECOND


def _sample(parent, child, X):
    pose = pose_array(X)
    return PoseSample(parent, child, pose[:4], pose[4:])


def _moving(parent, child, seconds, X):
    time = T0 + round(seconds * SECOND)
    return Stamped(time, time, _sample(parent, child, X))


def _tree(moving=(), static=(), notes=None):
    return make_transform_tree(
        moving,
        [_sample(*s) for s in static],
        notes=notes or LogNotes(),
    )


def _resolve(tree, frame, reference, *seconds):
    times = np.array([T0 + round(s * SECOND) for s in seconds])
    q, p = tree.Resolve(frame, reference, times)
    return [
        None if np.any(np.isnan(row)) else rigid_transform(row)
        for row in np.hstack([q, p])
    ]


def _random_pose(rng):
    return RigidTransform(
        RollPitchYaw(rng.uniform(-3, 3, 3)), rng.normal(size=3)
    )


def test_static_frames_are_composed_up_and_down_the_tree():
    rng = np.random.default_rng(0)
    X = {child: _random_pose(rng) for child in "abcd"}
    # world -> a -> b, world -> c -> d
    parents = {"a": "world", "b": "a", "c": "world", "d": "c"}
    tree = _tree(static=[(parents[f], f, X[f]) for f in X])
    (found,) = _resolve(tree, "b", "d", 0.0)
    expected = (X["c"] @ X["d"]).inverse() @ X["a"] @ X["b"]
    assert found.IsNearlyEqualTo(expected, 1e-12)
    (same,) = _resolve(tree, "b", "b", 0.0)
    assert same.IsNearlyEqualTo(RigidTransform(), 1e-12)


def test_a_motion_is_interpolated_at_the_stamp():
    def turned(angle):
        return RigidTransform(RollPitchYaw(0, 0, angle), [angle, 0, 0])

    tree = _tree(
        [_moving("w", "a", 0.1 * i, turned(0.3 * i)) for i in range(4)]
    )
    for seconds in (0.0, 0.05, 0.17, 0.3):
        (found,) = _resolve(tree, "a", "w", seconds)
        assert found.IsNearlyEqualTo(turned(3 * seconds), 1e-9)


def test_two_motions_are_resolved_at_one_time():
    shift = [RigidTransform([0.1 * i, 0, 0]) for i in range(10)]
    up = [RigidTransform([0, 0, -0.2 * i]) for i in range(10)]
    tree = _tree(
        [_moving("w", "a", 0.1 * i, shift[i]) for i in range(10)]
        + [_moving("a", "b", 0.1 * i + 0.03, up[i]) for i in range(10)]
    )
    (found,) = _resolve(tree, "b", "w", 0.43)
    np.testing.assert_allclose(found.translation(), [0.43, 0, -0.8], atol=1e-9)


def test_a_motion_is_unknown_before_after_and_in_long_gaps():
    places = [0.0, 0.1, 5.0, 5.1]
    tree = _tree(
        [_moving("w", "a", s, RigidTransform([s, 0, 0])) for s in places]
    )
    found = _resolve(tree, "a", "w", -0.2, -0.05, 0.05, 2.0, 5.15, 5.3)
    assert [x is not None for x in found] == [
        False,
        True,
        True,
        False,
        True,
        False,
    ]


def test_a_frame_that_never_moves_is_known_at_all_times():
    # As those of a static publisher of ROS 1, whose stamps are in the future.
    X = RigidTransform([1, 2, 3])
    tree = _tree([_moving("w", "a", 10 + i, X) for i in range(3)])
    for found in _resolve(tree, "a", "w", 0.0, 11.5, 1e6):
        assert found.IsExactlyEqualTo(X)


def test_frames_of_two_trees_are_not_connected():
    X = RigidTransform()
    tree = _tree(static=[("w", "a", X), ("v", "b", X)])
    assert tree.Connects("a", "w") and not tree.Connects("a", "b")
    assert _resolve(tree, "a", "b", 0.0) == [None]
    assert _resolve(tree, "nowhere", "w", 0.0) == [None]


def test_a_loop_is_no_endless_one():
    X = RigidTransform()
    tree = _tree(static=[("b", "a", X), ("a", "b", X)])
    assert not tree.Connects("a", "w")


def test_of_two_parents_the_usual_one_counts_and_it_is_said():
    notes = LogNotes()
    X = [RigidTransform([i, 0, 0]) for i in range(4)]
    moving = [_moving("w", "a", 0.1 * i, X[i]) for i in range(3)]
    tree = _tree([*moving, _moving("v", "a", 0.3, X[3])], notes=notes)
    assert tree.motions["a"].parent == "w"
    (said,) = notes.Sentences()
    assert "a has the parents ['v', 'w']" in said and "left out 1" in said


def test_sample_times_are_those_of_what_moves():
    X = [RigidTransform([i, 0, 0]) for i in range(3)]
    tree = _tree(
        [_moving("w", "a", i, X[i]) for i in range(3)]
        + [_moving("a", "b", i + 0.5, X[i]) for i in range(3)],
        [("b", "c", X[1])],
    )
    times = (tree.SampleTimes("c", "w") - T0) / SECOND
    assert times.tolist() == [0, 0.5, 1, 1.5, 2, 2.5]
    assert len(tree.SampleTimes("c", "b")) == 0
