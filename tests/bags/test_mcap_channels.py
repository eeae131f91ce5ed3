"""Channels of an MCAP file: of other encodings, and without a schema."""

from mcap.writer import Writer
from mcap_ros2._dynamic import serialize_dynamic
import pytest

from pbpf_drake.bags.mcap_stream import McapStream
from pbpf_drake.bags.ros2_messages import JOINT_STATE, message_definition


def _write_channels(path, messages):
    """Writes (topic, encoding, type, data) as one channel each."""
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channels = {}
        for time, (topic, encoding, kind, data) in enumerate(messages):
            key = topic, encoding, kind
            if key not in channels:
                text = message_definition(kind).encode() if kind else b""
                schema = (
                    writer.register_schema(kind, "ros2msg", text) if kind else 0
                )
                channels[key] = writer.register_channel(topic, encoding, schema)
            writer.add_message(channels[key], time, data, time)
        writer.finish()


def _joint_state(value):
    encode = serialize_dynamic(JOINT_STATE, message_definition(JOINT_STATE))
    header = {"stamp": {"sec": 5, "nanosec": 7}}
    return encode[JOINT_STATE](
        {"header": header, "name": ["a"], "position": [value]}
    )


def test_the_type_of_a_channel_without_a_schema_is_found_out(tmp_path):
    path = tmp_path / "log"
    _write_channels(
        path, [("/j", "cdr", "", _joint_state(i)) for i in range(9)]
    )
    stream = McapStream(filename=path)
    assert [m.type for m in stream.Messages()] == [JOINT_STATE] * 9
    assert stream.types == {"/j": JOINT_STATE}
    (said,) = stream.damage
    assert said.startswith("/j: the file does not say of what type")


@pytest.mark.parametrize("json_first", [True, False])
def test_messages_in_another_encoding_beside_those_of_ros_are_counted(
    tmp_path, json_first
):
    path = tmp_path / "log"
    messages = [("/j", "cdr", JOINT_STATE, _joint_state(i)) for i in range(9)]
    others = [("/j", "json", "", b"{}")] * 3
    _write_channels(
        path, others + messages if json_first else messages + others
    )
    stream = McapStream(filename=path)
    assert [m.encoding for m in stream.Messages()] == ["cdr"] * 9
    assert stream.types == {"/j": JOINT_STATE}
    assert stream.damage == [
        "left out 3 messages of /j encoded as 'json', beside those of ROS"
    ]
