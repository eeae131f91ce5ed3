"""Where messages end, and that they don't end behind their last byte."""

import struct

from bag_fixtures import our_entries, write_mcap, write_ros1
from log_fixtures import make_small_log
import pytest

from pbpf_drake.bags.log_container import OpenLogStream
from pbpf_drake.bags.message_extent import MessageExtent
from pbpf_drake.bags.ros2_messages import message_definition, short_type_name
from pbpf_drake.bags.type_definitions import parse_definition


def _extent(text, *, aligned=True):
    types = parse_definition("a/A", text, 10_000)
    return MessageExtent(types, "a/A", aligned=aligned)


@pytest.mark.parametrize("write", [write_mcap, write_ros1])
def test_whole_messages_end_at_their_last_byte(write, tmp_path):
    path = write(tmp_path / "log", our_entries(make_small_log()))
    for message in OpenLogStream(path).Messages():
        is_ros2 = message.encoding == "cdr"
        text = (
            message_definition(message.type) if is_ros2 else message.definition
        )
        types = parse_definition(message.type, text, 10**5)
        extent = MessageExtent(
            types, short_type_name(message.type), aligned=is_ros2
        )
        body = memoryview(message.data)[4 if is_ros2 else 0 :]
        assert 0 <= len(body) - extent.End(body) < 4
        with pytest.raises(ValueError):
            extent.End(body[:-4])


def test_numbers_are_aligned_in_ros2_only():
    text = "uint8 a\nfloat64 b\nuint16 c"
    assert _extent(text).End(memoryview(bytes(50))) == 18
    assert _extent(text, aligned=False).End(memoryview(bytes(50))) == 11


@pytest.mark.parametrize("text", ["string[] x", "float64[] x", "uint8[] x"])
@pytest.mark.parametrize("count", [100, 2**31, 2**32 - 1])
def test_a_length_that_can_not_be_is_refused_at_once(text, count):
    data = struct.pack("<I", count) + b"\xfc\xff\xff\xff" * 20
    with pytest.raises(ValueError):
        _extent(text).End(memoryview(data))


def test_a_string_of_ros2_ends_with_a_zero():
    text = "string x"
    good, bad = b"\2\0\0\0a\0", b"\2\0\0\0ab"
    assert _extent(text).End(memoryview(good)) == 6
    with pytest.raises(ValueError, match="no end"):
        _extent(text).End(memoryview(bad))
    assert _extent(text, aligned=False).End(memoryview(bad)) == 6


def test_lengths_may_be_of_the_other_byte_order():
    data = memoryview(b"\0\0\0\2ab")
    assert _extent("uint8[] x").End(data, little_endian=False) == 6
    with pytest.raises(ValueError, match="too many"):
        _extent("uint8[] x").End(data)
