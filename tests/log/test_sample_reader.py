"""Samples are read from whatever is a log, and nothing else is."""

from log_fixtures import has_warning, read_small_log
from mcap.writer import Writer as McapWriter
from mcap_fixtures import (
    DETECTIONS,
    JOINT_STATES,
    SECOND,
    T0,
    TRUTH,
    FaultyLog,
    pose,
)
from mcap_ros2._dynamic import serialize_dynamic
import pytest

from pbpf_drake.bags.detection_layouts import old_definition
from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.bags.read_limits import ReadLimits
from pbpf_drake.bags.ros2_messages import JOINT_STATE, message_definition
from pbpf_drake.log.sample_extraction import DETECTION_TYPES, JOINT_TYPES
from pbpf_drake.log.sample_reader import ReadSamples


def test_a_missing_file_is_refused(path):
    with pytest.raises(LogError, match=f"{path}: .*No such file"):
        read_small_log(path)


def test_a_folder_without_a_recording_is_refused(tmp_path):
    with pytest.raises(LogError, match="folder without metadata.yaml"):
        read_small_log(tmp_path)


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
        read_small_log(path)


def test_a_topic_of_another_type_is_refused(faulty):
    faulty.write(JOINT_STATES, "geometry_msgs/msg/PoseArray", {}, 0.0)
    with pytest.raises(
        LogError,
        match="topic /joint_states has messages of type "
        "'geometry_msgs/msg/PoseArray'; expected sensor_msgs/msg/JointState",
    ):
        faulty.read()


def _write_channels(path, channels):
    """Writes (topic, type, definition, messages) as one channel each."""
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        for topic, kind, text, messages in channels:
            schema = (
                writer.register_schema(kind, "ros2msg", text.encode())
                if kind
                else 0
            )
            channel = writer.register_channel(topic, "cdr", schema)
            for i, data in enumerate(messages):
                writer.add_message(channel, i, data, i)
        writer.finish()


def test_messages_of_another_type_beside_the_right_ones_are_counted(path):
    text = message_definition(JOINT_STATE)
    data = serialize_dynamic(JOINT_STATE, text)[JOINT_STATE]({"name": ["a"]})
    _write_channels(
        path,
        [
            (JOINT_STATES, "std_msgs/msg/Empty", "", [b"\0\1\0\0\0"] * 3),
            (JOINT_STATES, JOINT_STATE, text, [data] * 5),
        ],
    )
    notes = LogNotes()
    samples = ReadSamples(path, {JOINT_STATES: JOINT_TYPES}, notes)
    assert len(samples.joints[JOINT_STATES]) == 5
    (said,) = notes.Sentences()
    assert "left out 3 messages of type 'std_msgs/msg/Empty'" in said


def test_a_type_that_is_not_named_and_fits_none_is_refused(path):
    _write_channels(
        path, [(JOINT_STATES, "", "", [b"\0\1\0\0\7\0\0\0text..."])]
    )
    with pytest.raises(LogError, match="type that the file does not name"):
        read_small_log(path)


def test_what_is_beyond_a_limit_is_counted(path):
    with FaultyLog(path) as log:
        for i in range(50):
            log.joints(i)
    notes = LogNotes()
    limits = ReadLimits(decoded=1000, decoded_growth=0)
    types = {JOINT_STATES: JOINT_TYPES}
    samples = ReadSamples(path, types, notes, limits)
    assert 5 < len(samples.joints[JOINT_STATES]) < 20
    left_out = 50 - len(samples.joints[JOINT_STATES])
    (said,) = notes.Sentences()
    assert f"left out {left_out} messages beyond what is decoded" in said


def test_a_layout_that_was_found_out_is_said(path):
    kind = "vision_msgs/msg/Detection3DArray"
    text = old_definition("string", tracking=True)
    result = {
        "id": "box",
        "score": 1.0,
        "pose": {"pose": pose((1, 0, 0, 0), (0, 0, 1))},
    }
    data = serialize_dynamic(kind, text)[kind](
        {"detections": [{"results": [result]}]}
    )
    _write_channels(path, [(DETECTIONS, kind, "", [data] * 9)])
    notes = LogNotes()
    samples = ReadSamples(path, {DETECTIONS: DETECTION_TYPES}, notes)
    assert [p.value.name for p in samples.poses[DETECTIONS]] == ["box"] * 9
    (said,) = notes.Sentences()
    assert "only that of ROS 2 Foxy fits" in said


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
        read_small_log(path)


def test_a_message_that_can_not_be_decoded_is_left_out(faulty):
    faulty.joints(0.0)
    faulty.detection(0.0)
    faulty.raw(JOINT_STATES, b"\0\1\0\0\1\2\3", 0.1)
    faulty.raw(JOINT_STATES, b"", 0.2)
    faulty.raw(DETECTIONS, b"\0\1\0\0" + b"\xff" * 40, 0.2)
    faulty.joints(0.3)
    log = faulty.read()
    assert log.joints.times.tolist() == [0.0, 0.3]
    assert has_warning(log, JOINT_STATES, "2 messages that can't be decoded")
    assert has_warning(log, DETECTIONS, "1 message that can't be decoded")


def test_samples_are_those_of_the_topics_that_are_asked_for(path, faulty):
    for time in (0.2, 0.1):
        faulty.joints(time)
        faulty.detection(time)
        faulty.truth(time)
    faulty.__exit__()
    types = {
        JOINT_STATES: JOINT_TYPES,
        "/other": (),
        DETECTIONS: DETECTION_TYPES,
    }
    notes = LogNotes()
    samples = ReadSamples(path, types, notes)
    # As they are in the file.
    stamps = [m.stamp - T0 for m in samples.joints[JOINT_STATES]]
    assert stamps == [SECOND // 5, SECOND // 10]
    assert [m.value.name for m in samples.poses[DETECTIONS]] == ["box", "box"]
    assert samples.poses["/other"] == []
    assert samples.counts == {JOINT_STATES: 2, DETECTIONS: 2}
    assert TRUTH not in samples.poses and TRUTH in samples.types
    assert notes.Sentences() == ()
