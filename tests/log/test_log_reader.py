from log_fixtures import (
    JOINT_NAMES,
    START_TIME,
    make_small_log,
    make_small_scene,
)
from mcap.reader import make_reader
from mcap.writer import Writer as McapWriter
from mcap_fixtures import DETECTIONS, JOINT_STATES, T0, FaultyLog, pose
from mcap_ros2.decoder import DecoderFactory
import numpy as np
from paths import DATA
import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.ros2_messages import DETECTION_ARRAY, message_definition
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.mcap_log_writer import WriteLog

LOGS = DATA / "logs"


def _round_trip(path, log, scene, joint_names=JOINT_NAMES):
    WriteLog(filename=path, scene_topics=scene.topics, log=log)
    return ReadLog(filename=path, scene=scene, joint_names=joint_names)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "log.mcap"


@pytest.fixture
def faulty(path):
    """A log to which a test adds faults; it has detections every second."""
    with FaultyLog(path) as log:
        yield log


def _read(path, log=None, scene=None, names=("a", "b")):
    if log:
        log.__exit__()
    scene = scene or make_small_scene()
    return ReadLog(filename=path, scene=scene, joint_names=names)


def _has(log, *parts):
    """Whether one warning has all parts."""
    return any(all(p in w for p in parts) for w in log.warnings)


@pytest.mark.parametrize("velocities", [True, False])
def test_a_written_log_is_read_back_to_the_bit(path, velocities):
    log = make_small_log(velocities=velocities)
    found = _round_trip(path, log, make_small_scene())
    assert found.warnings == ()
    assert found.start_time == START_TIME
    assert found.joints.names == log.joints.names
    np.testing.assert_array_equal(found.joints.times, log.joints.times)
    np.testing.assert_array_equal(found.joints.positions, log.joints.positions)
    np.testing.assert_array_equal(
        found.joints.velocities, log.joints.velocities
    )
    truth, expected = found.ground_truth["box"], log.ground_truth["box"]
    np.testing.assert_array_equal(truth.times, expected.times)
    np.testing.assert_array_equal(truth.p_WO, expected.p_WO)
    np.testing.assert_array_equal(truth.q_WO, expected.q_WO)
    assert len(found.detections) == len(log.detections)
    for a, b in zip(found.detections, log.detections, strict=True):
        assert (a.name, a.time, a.received) == (b.name, b.time, b.received)
        assert a.X_CO.IsNearlyEqualTo(b.X_CO, 1e-15)
        np.testing.assert_array_equal(
            a.X_CO.translation(), b.X_CO.translation()
        )


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
    found = _read(path, None, scene, ["wrist", "slide_x"])
    assert found.joints.names == ("wrist", "slide_x")
    np.testing.assert_array_equal(
        found.joints.positions, log.joints.positions[:, [2, 0]]
    )
    np.testing.assert_array_equal(
        found.joints.velocities, log.joints.velocities[:, [2, 0]]
    )
    assert {d.name for d in found.detections} == {"box"}
    assert _has(found, "/joint_states", "ignored the joints ['slide_y']")
    assert len(found.warnings) == 1


# -- Files that are no logs.


def test_a_missing_file_is_refused(path):
    with pytest.raises(LogError, match=f"{path}: .*No such file"):
        _read(path)


def test_a_folder_without_a_recording_is_refused(tmp_path):
    with pytest.raises(LogError, match="folder without metadata.yaml"):
        _read(tmp_path)


@pytest.mark.parametrize(
    "content, expected",
    [
        (b"", "it is empty"),
        (b"hello", "b'hello'"),
        (b"#ROSBAG V1.2\n....", "it is a bag of a version before 2.0"),
        (b"\x89MCAP", "b'.x89MCAP'"),
    ],
)
def test_a_file_of_another_format_is_refused(path, content, expected):
    path.write_bytes(content)
    with pytest.raises(LogError, match=f"expected an MCAP file.*{expected}"):
        _read(path)


def test_a_log_without_joint_states_names_its_topics(path, faulty):
    faulty.detection(0.0)
    with pytest.raises(LogError) as error:
        _read(path, faulty)
    message = str(error.value)
    assert "there are no joint states" in message
    assert "sensor_msgs/msg/JointState on the topic /joint_states" in message
    assert f"{DETECTIONS} ({DETECTION_ARRAY})" in message


def test_a_log_without_messages_is_refused(path, faulty):
    with pytest.raises(LogError, match="the topics are: none"):
        _read(path, faulty)


def test_a_topic_of_another_type_is_refused(path, faulty):
    faulty.write(JOINT_STATES, "geometry_msgs/msg/PoseArray", {}, 0.0)
    with pytest.raises(
        LogError,
        match="topic /joint_states has messages of type "
        "'geometry_msgs/msg/PoseArray'; expected sensor_msgs/msg/JointState",
    ):
        _read(path, faulty)


def test_another_encoding_is_refused(path):
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        schema = writer.register_schema(
            "sensor_msgs/JointState", "jsonschema", b""
        )
        channel = writer.register_channel(JOINT_STATES, "json", schema)
        writer.add_message(channel, 5, b"1234", 5)
        writer.finish()
    with pytest.raises(LogError, match="encoded as 'json'; expected cdr"):
        _read(path)


def test_a_renamed_joint_that_the_robot_lacks_is_refused(path, faulty):
    faulty.joints(0.0)
    scene = make_small_scene()
    scene.topics.joint_names = {"elbow": "a"}
    with pytest.raises(LogError, match=r"joint_names names \['elbow'\]"):
        _read(path, faulty, scene)


def test_a_detection_is_received_at_its_log_time(path, faulty):
    faulty.joints(0.0)
    faulty.detection(0.3, delay=0.2)
    faulty.detection(0.4, delay=0.05)
    faulty.detection(0.6, delay=-0.1)
    log = _read(path, faulty)
    times = [(d.time, d.received) for d in log.detections]
    assert times == [(0.4, 0.45), (0.3, 0.5), (0.6, 0.6)]


def test_a_message_without_a_stamp_gets_its_log_time(path, faulty):
    faulty.joints(0.0, stamp=0)
    faulty.joints(0.5, stamp=0)
    faulty.detection(0.25, stamp=0)
    log = _read(path, faulty)
    assert log.start_time == T0
    assert log.joints.times.tolist() == [0.0, 0.5]
    assert [(d.time, d.received) for d in log.detections] == [(0.25, 0.25)]


def test_a_message_that_can_not_be_decoded_is_left_out(path, faulty):
    faulty.joints(0.0)
    faulty.detection(0.0)
    faulty.raw(JOINT_STATES, b"\0\1\0\0\1\2\3", 0.1)
    faulty.raw(JOINT_STATES, b"", 0.2)
    faulty.raw(DETECTIONS, b"\0\1\0\0" + b"\xff" * 40, 0.2)
    faulty.joints(0.3)
    log = _read(path, faulty)
    assert log.joints.times.tolist() == [0.0, 0.3]
    assert _has(log, JOINT_STATES, "2 messages that can't be decoded")
    assert _has(log, DETECTIONS, "1 message that can't be decoded")


@pytest.mark.parametrize("fields", ["string id", "int64 id", "string class_id"])
def test_detections_of_older_layouts_are_read(path, faulty, fields):
    name = fields.split()[1]
    text = message_definition(DETECTION_ARRAY).replace(
        "vision_msgs/ObjectHypothesis hypothesis", f"{fields}\nfloat64 score"
    )
    faulty.define(DETECTION_ARRAY, text)
    scene = make_small_scene()
    scene.tracked["box"].class_id = "7"
    value = 7 if "int" in fields else "7"
    result = {
        name: value,
        "score": 0.5,
        "pose": {"pose": pose([1, 0, 0, 0], [1, 2, 3])},
    }
    faulty.joints(0.0)
    faulty.write(
        DETECTIONS,
        DETECTION_ARRAY,
        {"detections": [{"results": [result]}]},
        0.1,
    )
    (detection,) = _read(path, faulty, scene).detections
    assert detection.X_CO.translation().tolist() == [1, 2, 3]


def test_the_hypothesis_with_the_highest_score_counts(path, faulty):
    faulty.joints(0.0)
    results = [
        {"hypothesis": {"class_id": name, "score": score}}
        for name, score in [("mug", 0.2), ("box", 0.7), ("pan", 0.1)]
    ]
    faulty.write(
        DETECTIONS,
        DETECTION_ARRAY,
        {"detections": [{"results": results}, {"results": []}]},
        0.1,
    )
    log = _read(path, faulty)
    assert [d.name for d in log.detections] == ["box"]
    assert _has(log, "1 detection of the unknown class ''")


# -- Logs that others recorded.


@pytest.mark.skipif(not LOGS.is_dir(), reason="no recorded logs here")
def test_recorded_logs_without_the_topic_are_refused():
    logs = sorted(LOGS.iterdir())
    assert logs
    for log in logs:
        with pytest.raises(LogError, match="no joint states|MCAP file"):
            _read(log)


@pytest.mark.skipif(not LOGS.is_dir(), reason="no recorded logs here")
def test_a_recorded_log_is_read():
    path = LOGS / "prismax_bimanual_jointstates_ros2.mcap"
    topic = "/robot/arm_left_follow/joint_states"
    scene = make_small_scene()
    scene.topics.joint_states = topic
    names = ["gripper", "shoulder_pan", "elbow_flex"]
    log = _read(path, None, scene, names)
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
    assert _has(log, "ignored the joints")
    # The other one is that there are no detections.
    assert len(log.warnings) == 2
