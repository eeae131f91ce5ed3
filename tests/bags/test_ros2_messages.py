from io import BytesIO
import struct

from mcap.reader import make_reader
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from mcap_ros2.writer import Writer
import numpy as np
import pytest

from pbpf_drake.bags import ros2_messages
from pbpf_drake.bags.ros2_messages import (
    IMAGE,
    POSE_STAMPED,
    header_message,
    message_definition,
    pose_arrays,
    pose_message,
    stamp_of,
    to_nanoseconds,
)

TYPES = [
    value
    for name, value in vars(ros2_messages).items()
    if name.isupper() and not name.startswith("_")
]


def _write_and_read(name, message):
    file = BytesIO()
    with Writer(file) as writer:
        schema = writer.register_msgdef(name, message_definition(name))
        writer.write_message("/topic", schema, message, log_time=5)
    reader = make_reader(
        BytesIO(file.getvalue()), decoder_factories=[DecoderFactory()]
    )
    (found,) = reader.iter_decoded_messages()
    return found


@pytest.mark.parametrize("name", [IMAGE, "sensor_msgs/CompressedImage"])
def test_definitions_can_be_parsed(name):
    text = message_definition(name)
    schema = Schema(id=1, data=text.encode(), encoding="ros2msg", name=name)
    assert DecoderFactory().decoder_for("cdr", schema) is not None


@pytest.mark.parametrize("name", TYPES)
def test_every_definition_is_complete(name):
    stamped = {"header": {"frame_id": "f"}}
    is_tf = name == "tf2_msgs/msg/TFMessage"
    found = _write_and_read(
        name, {"transforms": [stamped]} if is_tf else stamped
    )
    assert found.schema.name == name
    decoded = found.decoded_message
    header = (decoded.transforms[0] if is_tf else decoded).header
    assert header.frame_id == "f"
    assert "/msg/" not in message_definition(name)


def test_a_pose_stamped_has_the_bytes_of_the_cdr_standard():
    message = {
        "header": header_message(stamp=7_000_000_009, frame_id="world"),
        "pose": pose_message(q=np.array([0.5, -0.5, 0.5, -0.5]), p=[1, 2, 3]),
    }
    expected = (
        bytes([0, 1, 0, 0])  # Little endian.
        + struct.pack("<iI", 7, 9)
        + struct.pack("<I", 6)
        + b"world\0"
        + bytes(6)  # Doubles start at a multiple of 8 after the first 4.
        + struct.pack("<3d", 1, 2, 3)
        + struct.pack("<4d", -0.5, 0.5, -0.5, 0.5)  # x, y, z, w.
    )
    assert _write_and_read(POSE_STAMPED, message).message.data == expected


def test_poses_survive():
    q, p = np.array([0.1, 0.2, 0.3, 0.4]), np.array([5.0, 6.0, 7.0])
    pose = _write_and_read(
        POSE_STAMPED, {"pose": pose_message(q=q, p=p)}
    ).decoded_message.pose
    assert (pose.orientation.w, pose.orientation.z) == (0.1, 0.4)
    for found, expected in zip(pose_arrays(pose), (q, p), strict=True):
        np.testing.assert_array_equal(found, expected)


def test_stamps_survive():
    stamp = 1_700_000_000_999_999_999
    header = header_message(stamp=stamp, frame_id="")
    message = _write_and_read(POSE_STAMPED, {"header": header})
    assert stamp_of(message.decoded_message.header) == stamp


def test_times_of_whole_nanoseconds_are_exact():
    start = 1_700_000_000_123_456_789
    for count in (0, 1, 333_333_333, 86_400 * 10**9 + 1):
        assert to_nanoseconds(start_time=start, time=count / 1e9) == (
            start + count
        )
