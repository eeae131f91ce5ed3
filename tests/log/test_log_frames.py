"""Poses in the log's frames become poses in the scene's."""

from authors_fixtures import transform
from bag_fixtures import write_mcap, write_ros1
import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RollPitchYaw
import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.ros2_messages import (
    DETECTION_ARRAY,
    JOINT_STATE,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    TF_MESSAGE,
    TRANSFORM_STAMPED,
    header_message,
    pose_message,
)
from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.config.log_topics import LogTopics
from pbpf_drake.config.scene_config import Scene, TrackedObject
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.poses.pose_conversion import pose_array

T0 = 1000 * 10**9
X_WR = RigidTransform(RollPitchYaw(0, 0, 0.3), [0.1, 0.2, 0.3])
X_RC = RigidTransform(RollPitchYaw(-2, 0.1, 1.5), [1.0, 0.1, 0.5])
X_SCENE_CAMERA = RigidTransform(RollPitchYaw(-2, 0, 1.5), [1.1, 0.2, 0.9])
X_CO = RigidTransform(RollPitchYaw(0.4, 0.5, 0.6), [0.05, -0.1, 0.9])
X_RO = X_RC @ X_CO


class Bag:
    """Collects messages; times are seconds after T0."""

    def __init__(self):
        self.entries = []
        for i in range(11):
            self.add(
                0.1 * i, "/joint_states", JOINT_STATE, name=["a"], position=[i]
            )

    def add(self, time, topic, kind, *, frame="", **message):
        stamp = T0 + round(1e9 * time)
        if kind != TF_MESSAGE:
            header = header_message(stamp=stamp, frame_id=frame)
            message = {"header": header, **message}
        self.entries.append((stamp, topic, kind, message))

    def tf(self, time, parent, child, X, topic="/tf"):
        stamp = T0 + round(1e9 * time)
        tf = transform(stamp, parent, child, X)
        self.add(time, topic, TF_MESSAGE, transforms=[tf])

    def pose(self, time, topic, kind, frame, X, name="box"):
        q, p = pose_array(X)[:4], pose_array(X)[4:]
        pose = pose_message(q=q, p=p)
        if kind == TRANSFORM_STAMPED:
            message = transform(0, frame, name, X)
            del message["header"]
        elif kind == DETECTION_ARRAY:
            result = {
                "hypothesis": {"class_id": name, "score": 1.0},
                "pose": {"pose": pose},
            }
            message = {"detections": [{"results": [result]}]}
        elif kind == POSE_WITH_COVARIANCE_STAMPED:
            message = {"pose": {"pose": pose}}
        else:
            message = {"pose": pose}
        self.add(time, topic, kind, frame=frame, **message)

    def read(self, tmp_path, write=write_mcap, tracked=("box",), **topics):
        path = write(tmp_path / "log", sorted(self.entries, key=lambda e: e[0]))
        camera = CameraConfig(X_WC=Transform(X_SCENE_CAMERA))
        scene = Scene(
            robot="arm",
            tracked={name: TrackedObject() for name in tracked},
            camera=camera,
            topics=LogTopics(
                reference_frame="base", X_WR=Transform(X_WR), **topics
            ),
        )
        scene.topics.ValidateOrThrow()
        return ReadLog(filename=path, scene=scene, joint_names=["a"])


@pytest.fixture
def bag():
    return Bag()


def _world_pose(log, index=0):
    """Where a detection is said to be in the world."""
    X_WC = log.X_WC or X_SCENE_CAMERA
    return X_WC @ log.detections[index].X_CO


_TYPES = [
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    TRANSFORM_STAMPED,
    DETECTION_ARRAY,
]


@pytest.mark.parametrize("write", [write_mcap, write_ros1])
@pytest.mark.parametrize("kind", _TYPES)
def test_detections_of_all_types_are_placed_by_tf(tmp_path, bag, kind, write):
    bag.tf(0.0, "base", "/camera", X_RC, topic="/tf_static")
    bag.pose(0.5, "/seen", kind, "/camera", X_CO)
    log = bag.read(tmp_path, write, detections="/seen", camera_frame="/camera")
    assert [d.name for d in log.detections] == ["box"]
    assert log.X_WC.IsNearlyEqualTo(X_WR @ X_RC, 1e-12)
    assert log.detections[0].X_CO.IsNearlyEqualTo(X_CO, 1e-12)


def test_without_the_camera_in_tf_it_is_where_the_scene_says(tmp_path, bag):
    bag.pose(0.5, "/seen", POSE_STAMPED, "camera", X_CO)
    bag.pose(0.6, "/seen", POSE_STAMPED, "base", X_RO)
    log = bag.read(tmp_path, detections="/seen", camera_frame="camera")
    assert log.X_WC is None
    assert log.detections[0].X_CO.IsNearlyEqualTo(X_CO, 1e-12)
    assert _world_pose(log, 1).IsNearlyEqualTo(X_WR @ X_RO, 1e-12)
    assert any("taken to be where the scene says" in w for w in log.warnings)


def test_detections_in_tf_are_placed_at_their_stamps(tmp_path, bag):
    # The camera moves along x while the box rests in the world.
    for i in range(11):
        shift = RigidTransform([0.001 * i, 0, 0])
        bag.tf(0.1 * i, "base", "camera", shift @ X_RC)
        seen = (shift @ X_RC).inverse() @ X_RO
        if i % 2:
            bag.tf(0.1 * i, "camera", "box", seen)
    log = bag.read(tmp_path, detections="tf:{name}", camera_frame="camera")
    assert [d.time for d in log.detections] == [0.1, 0.3, 0.5, 0.7, 0.9]
    for i in range(5):
        assert _world_pose(log, i).IsNearlyEqualTo(X_WR @ X_RO, 1e-12)


def test_a_camera_that_moves_is_said(tmp_path, bag):
    for i in range(11):
        shift = RigidTransform([0.1 * i, 0, 0])
        bag.tf(0.1 * i, "base", "camera", shift @ X_RC)
    bag.pose(0.5, "/seen", POSE_STAMPED, "base", X_RO)
    log = bag.read(tmp_path, detections="/seen", camera_frame="camera")
    assert any("the camera moves, by up to 0.5" in w for w in log.warnings)
    assert _world_pose(log).IsNearlyEqualTo(X_WR @ X_RO, 1e-12)


def test_what_tf_does_not_connect_is_left_out_and_counted(tmp_path, bag):
    for i in range(4):
        bag.pose(0.1 * i, "/seen", POSE_STAMPED, "moon", X_CO)
    bag.pose(0.6, "/seen", POSE_STAMPED, "base", X_RO)
    log = bag.read(tmp_path, detections="/seen")
    assert [d.time for d in log.detections] == [0.6]
    said = "/seen: left out 4 detections in the frame 'moon', which nothing"
    assert any(said in w for w in log.warnings)


def test_several_objects_have_a_topic_each(tmp_path, bag):
    for i, name in enumerate(("box", "can")):
        shift = RigidTransform([0, 0, i])
        bag.pose(0.2, f"/{name}/seen", POSE_STAMPED, "base", shift @ X_RO)
        bag.pose(0.3, f"/{name}/truth", POSE_STAMPED, "base", shift @ X_RO)
    log = bag.read(
        tmp_path,
        tracked=("box", "can"),
        detections="/{name}/seen",
        ground_truth="/{name}/truth",
    )
    assert {d.name for d in log.detections} == {"box", "can"}
    for i, name in enumerate(("box", "can")):
        expected = X_WR @ RigidTransform([0, 0, i]) @ X_RO
        np.testing.assert_allclose(
            log.ground_truth[name].p_WO[0], expected.translation(), atol=1e-12
        )


def test_one_topic_of_truth_names_its_objects(tmp_path, bag):
    for i, name in enumerate(("box", "can")):
        shift = RigidTransform([0, 0, i])
        bag.pose(
            0.3, "/truth", TRANSFORM_STAMPED, "base", shift @ X_RO, name=name
        )
    log = bag.read(tmp_path, tracked=("box", "can"), ground_truth="/truth")
    heights = [log.ground_truth[n].p_WO[0, 2] for n in ("box", "can")]
    assert heights[1] - heights[0] == pytest.approx(1.0)


def test_truth_can_be_in_tf(tmp_path, bag):
    for i in range(3):
        bag.tf(0.1 * i, "base", "box", RigidTransform([0, 0, i]) @ X_RO)
    log = bag.read(tmp_path, ground_truth="tf:{name}")
    truth = log.ground_truth["box"]
    assert truth.times.tolist() == [0.0, 0.1, 0.2]
    expected = (X_WR @ X_RO).translation() + [[0, 0, i] for i in range(3)]
    np.testing.assert_allclose(truth.p_WO, expected, atol=1e-12)


def test_truth_is_relative_to_its_base_at_the_stamp(tmp_path, bag):
    # The whole motion capture drifts, the box rests on the robot's base.
    for i in range(11):
        X_MB = RigidTransform(RollPitchYaw(0, 0, 0.1 * i), [0.2 * i, 0, 0])
        bag.pose(0.1 * i, "/base", POSE_STAMPED, "mocap", X_MB)
        bag.pose(0.1 * i, "/box", POSE_STAMPED, "mocap", X_MB @ X_RO)
    log = bag.read(tmp_path, ground_truth="/box", ground_truth_base="/base")
    truth = log.ground_truth["box"]
    assert len(truth.times) == 11
    expected = np.tile((X_WR @ X_RO).translation(), (11, 1))
    np.testing.assert_allclose(truth.p_WO, expected, atol=1e-12)


def test_without_a_reference_frame_no_frame_is_looked_at(tmp_path, bag):
    bag.pose(0.5, "/seen", POSE_STAMPED, "moon", X_CO)
    path = write_mcap(tmp_path / "log", bag.entries)
    scene = Scene(
        robot="arm",
        tracked={"box": TrackedObject()},
        topics=LogTopics(detections="/seen"),
    )
    log = ReadLog(filename=path, scene=scene, joint_names=["a"])
    assert log.detections[0].X_CO.IsNearlyEqualTo(X_CO, 1e-12)
    assert log.warnings == ()


# -- Joints that are coordinates of frames.

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
