"""A log is read, whatever recorded it, or refused with reasons."""

from log_fixtures import (
    START_TIME,
    assert_same_log,
    has_warning,
    make_small_log,
    make_small_scene,
    read_small_log,
)
from mcap.reader import make_reader
from mcap_fixtures import DETECTIONS, T0
from mcap_ros2.decoder import DecoderFactory
import numpy as np
from paths import DATA
import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.ros2_messages import DETECTION_ARRAY
from pbpf_drake.log.mcap_log_writer import WriteLog

LOGS = DATA / "logs"


@pytest.mark.parametrize("velocities", [True, False])
def test_a_written_log_is_read_back_to_the_bit(path, velocities):
    log = make_small_log(velocities=velocities)
    WriteLog(filename=path, scene_topics=make_small_scene().topics, log=log)
    found = read_small_log(path)
    assert found.warnings == ()
    assert found.start_time == START_TIME
    assert_same_log(found, log)


def test_columns_follow_the_robot_and_names_the_scene(path):
    scene = make_small_scene()
    scene.topics.joint_names = {"slide_x": "x axis"}
    scene.tracked["box"].class_id = "the box"
    log = make_small_log()
    WriteLog(
        filename=path,
        scene_topics=scene.topics,
        log=log,
        class_ids={"box": "the box"},
    )
    found = read_small_log(path, scene, ["wrist", "slide_x"])
    assert found.joints.names == ("wrist", "slide_x")
    np.testing.assert_array_equal(
        found.joints.positions, log.joints.positions[:, [2, 0]]
    )
    np.testing.assert_array_equal(
        found.joints.velocities, log.joints.velocities[:, [2, 0]]
    )
    assert {d.name for d in found.detections} == {"box"}
    assert has_warning(found, "/joint_states", "ignored the joints ['slide_y']")
    assert len(found.warnings) == 1


def test_a_log_without_joint_states_names_its_topics(faulty):
    faulty.detection(0.0)
    with pytest.raises(LogError) as error:
        faulty.read()
    message = str(error.value)
    assert "there are no joint states" in message
    assert "sensor_msgs/msg/JointState on the topic /joint_states" in message
    assert f"{DETECTIONS} ({DETECTION_ARRAY})" in message


def test_a_log_without_messages_is_refused(faulty):
    with pytest.raises(LogError, match="the topics are: none"):
        faulty.read()


def test_a_renamed_joint_that_the_robot_lacks_is_refused(faulty):
    faulty.joints(0.0)
    scene = make_small_scene()
    scene.topics.joint_names = {"elbow": "a"}
    with pytest.raises(LogError, match=r"joint_names names \['elbow'\]"):
        faulty.read(scene)


def test_a_detection_is_received_at_its_log_time(faulty):
    faulty.joints(0.0)
    faulty.detection(0.3, delay=0.2)
    faulty.detection(0.4, delay=0.05)
    faulty.detection(0.6, delay=-0.1)
    log = faulty.read()
    times = [(d.time, d.received) for d in log.detections]
    assert times == [(0.4, 0.45), (0.3, 0.5), (0.6, 0.6)]


def test_a_message_without_a_stamp_gets_its_log_time(faulty):
    faulty.joints(0.0, stamp=0)
    faulty.joints(0.5, stamp=0)
    faulty.detection(0.25, stamp=0)
    log = faulty.read()
    assert log.start_time == T0
    assert log.joints.times.tolist() == [0.0, 0.5]
    assert [(d.time, d.received) for d in log.detections] == [(0.25, 0.25)]


# -- Logs that others recorded.


@pytest.mark.skipif(not LOGS.is_dir(), reason="no recorded logs here")
def test_recorded_logs_without_the_topic_are_refused():
    logs = sorted(LOGS.iterdir())
    assert logs
    for log in logs:
        with pytest.raises(LogError, match="no joint states|MCAP file"):
            read_small_log(log)


@pytest.mark.skipif(not LOGS.is_dir(), reason="no recorded logs here")
def test_a_recorded_log_is_read():
    path = LOGS / "prismax_bimanual_jointstates_ros2.mcap"
    topic = "/robot/arm_left_follow/joint_states"
    scene = make_small_scene()
    scene.topics.joint_states = topic
    names = ["gripper", "shoulder_pan", "elbow_flex"]
    log = read_small_log(path, scene, names)
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        messages = [
            m.decoded_message for m in reader.iter_decoded_messages([topic])
        ]
    columns = [messages[0].name.index(name) for name in names]
    positions = np.array([m.position for m in messages])[:, columns]
    np.testing.assert_array_equal(log.joints.positions, positions)
    assert 30 < log.duration < 60
    assert np.all(np.diff(log.joints.times) > 0)
    assert has_warning(log, "ignored the joints")
    # The other one is that there are no detections.
    assert len(log.warnings) == 2
