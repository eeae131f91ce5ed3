"""Decoders made of definitions: exact, or not at all."""

from mcap_ros2._dynamic import serialize_dynamic
import pytest

from pbpf_drake.bags.message_types import (
    definition_matches,
    make_ros1_decoder,
    make_ros2_decoder,
)
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS
from pbpf_drake.bags.ros2_messages import JOINT_STATE, message_definition

TEXT = message_definition(JOINT_STATE)
FIELDS = {"name": ["a", "bc"], "position": [0.1, 0.2]}
DATA = serialize_dynamic(JOINT_STATE, TEXT)[JOINT_STATE](FIELDS)


def test_a_message_is_decoded_from_its_first_byte_to_its_last():
    decode = make_ros2_decoder(JOINT_STATE, TEXT, DEFAULT_LIMITS)
    message = decode(DATA)
    assert message.name == ["a", "bc"] and list(message.position) == [0.1, 0.2]
    # Some fill a message up to a multiple of four bytes.
    assert decode(DATA + b"\0\0\0").name == ["a", "bc"]
    for data in (DATA[:-4], DATA + bytes(4), b"\0\7" + DATA[2:], b"", b"\0\1"):
        with pytest.raises(ValueError):
            decode(data)


def test_a_message_of_ros1_as_well():
    decode = make_ros1_decoder("a/A", "uint8[] x\nbool y", DEFAULT_LIMITS)
    data = b"\2\0\0\0ab\1"
    assert bytes(decode(data).x) == b"ab"
    for other in (data[:-1], data + b"\0", b"\xff\xff\xff\xff"):
        with pytest.raises(ValueError):
            decode(other)


def test_a_name_that_is_no_name_is_never_made_python_of():
    kind = "a/B:\n    raise SystemExit\nclass C"
    with pytest.raises(ValueError, match="no type can be named"):
        make_ros1_decoder(kind, "bool x", DEFAULT_LIMITS)
    assert not definition_matches(kind, "bool x", "*")


def test_a_definition_that_is_too_long_is_not_used():
    text = "\n".join(f"bool x{i}" for i in range(9000))
    with pytest.raises(ValueError, match="too long"):
        make_ros1_decoder("a/A", text, DEFAULT_LIMITS)
