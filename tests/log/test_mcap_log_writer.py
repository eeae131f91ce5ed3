from dataclasses import replace

from log_fixtures import START_TIME, make_small_log
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
import numpy as np
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.config.scene_config import LogTopics
from pbpf_drake.log.log_records import DetectionRecord
from pbpf_drake.log.mcap_log_writer import WriteLog


def _write(path, log=None, **kwargs):
    WriteLog(
        filename=path,
        scene_topics=kwargs.pop("topics", LogTopics()),
        log=log or make_small_log(),
        **kwargs,
    )


def _messages(path, topic):
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        found = list(reader.iter_decoded_messages(topics=[topic]))
    return [(m.message.log_time, m.decoded_message, m.schema) for m in found]


def _stamp(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("log") / "log.mcap"
    _write(path)
    return path


def test_joint_states_field_by_field(path):
    joints = make_small_log().joints
    found = _messages(path, "/joint_states")
    assert len(found) == len(joints.times)
    for i, (log_time, message, schema) in enumerate(found):
        assert schema.name == "sensor_msgs/msg/JointState"
        assert _stamp(message) == log_time == START_TIME + i * 10_000_000
        assert tuple(message.name) == joints.names
        assert message.position == joints.positions[i].tolist()
        assert message.velocity == joints.velocities[i].tolist()
        assert message.effort == []


def test_detections_field_by_field(path):
    detections = make_small_log().detections
    found = _messages(path, "/dope/detected_objects")
    assert len(found) == len(detections)
    for i, (log_time, message, schema) in enumerate(found):
        assert schema.name == "vision_msgs/msg/Detection3DArray"
        assert _stamp(message) == START_TIME + i * 100_000_000
        assert log_time == _stamp(message) + 30_000_000
        assert message.header.frame_id == "camera_color_optical_frame"
        (result,) = message.detections[0].results
        assert result.hypothesis.class_id == "box"
        q = result.pose.pose.orientation
        R = detections[i].X_CO.rotation().matrix()
        # The last column of a rotation matrix in terms of its quaternion.
        z = [
            2 * (q.x * q.z + q.w * q.y),
            2 * (q.y * q.z - q.w * q.x),
            1 - 2 * (q.x**2 + q.y**2),
        ]
        np.testing.assert_allclose(z, R[:, 2], atol=1e-15)
        p = result.pose.pose.position
        assert [p.x, p.y, p.z] == detections[i].X_CO.translation().tolist()


def test_ground_truth_field_by_field(path):
    record = make_small_log().ground_truth["box"]
    found = _messages(path, "/ground_truth/box")
    assert len(found) == len(record.times)
    for i, (log_time, message, schema) in enumerate(found):
        assert schema.name == "geometry_msgs/msg/PoseStamped"
        assert _stamp(message) == log_time == START_TIME + i * 15_000_000
        assert message.header.frame_id == "world"
        q, p = message.pose.orientation, message.pose.position
        assert [q.w, q.x, q.y, q.z] == record.q_WO[i].tolist()
        assert [p.x, p.y, p.z] == record.p_WO[i].tolist()


def test_messages_are_in_the_order_they_were_received(path):
    with path.open("rb") as file:
        reader = make_reader(file)
        times = [
            message.log_time
            for _, _, message in reader.iter_messages(log_time_order=False)
        ]
        assert reader.get_header().profile == "ros2"
        compressions = {
            chunk.compression for chunk in reader.get_summary().chunk_indexes
        }
    assert times == sorted(times)
    assert compressions == {"zstd"}


def test_the_same_log_gives_the_same_bytes(path, tmp_path):
    _write(tmp_path / "again.mcap")
    assert (tmp_path / "again.mcap").read_bytes() == path.read_bytes()


def test_what_one_image_shows_is_one_message(tmp_path):
    X = RigidTransform([0, 0, 1])
    log = replace(
        make_small_log(),
        detections=(
            DetectionRecord("box", 0.1, 0.2, X),
            DetectionRecord("can", 0.1, 0.2, X),
            DetectionRecord("can", 0.1, 0.3, X),
        ),
    )
    _write(tmp_path / "log.mcap", log, class_ids={"can": "soup"})
    found = _messages(tmp_path / "log.mcap", "/dope/detected_objects")
    classes = [
        [d.results[0].hypothesis.class_id for d in message.detections]
        for _, message, _ in found
    ]
    assert classes == [["box", "soup"], ["soup"]]


def test_topics_and_joints_are_named_by_the_scene(tmp_path):
    topics = LogTopics(
        joint_states="/arm/joints",
        detections="/seen",
        ground_truth="/truth/of/{name}",
        joint_names={"wrist": "j7"},
    )
    path = tmp_path / "log.mcap"
    _write(path, topics=topics)
    joint_states = _messages(path, "/arm/joints")
    assert joint_states[0][1].name == ["slide_x", "slide_y", "j7"]
    assert _messages(path, "/seen")
    assert _messages(path, "/truth/of/box")


@pytest.mark.parametrize("start_time", [0, -5])
def test_a_stamp_that_is_not_after_the_epoch_is_refused(tmp_path, start_time):
    log = replace(make_small_log(), start_time=start_time)
    with pytest.raises(ValueError, match=f"start_time is {start_time} ns"):
        _write(tmp_path / "log.mcap", log)
    assert not (tmp_path / "log.mcap").exists()
