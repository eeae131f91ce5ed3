import math

from bag_fixtures import our_entries, write_mcap, write_ros1
from log_fixtures import make_small_log
import pytest
import zstandard

from pbpf_drake.bags.log_container import OpenLogStream
from pbpf_drake.bags.log_stream import RawMessage
from pbpf_drake.bags.message_decoder import MessageDecoder
from pbpf_drake.bags.message_types import definition_matches

LOG = make_small_log()


@pytest.fixture(params=[write_mcap, write_ros1])
def message(request, tmp_path) -> RawMessage:
    """The first joint state of a log."""
    path = request.param(tmp_path / "log", our_entries(LOG))
    return next(OpenLogStream(path, ["/joint_states"]).Messages())


def _changed(message, **changes):
    return RawMessage(**{**vars(message), **changes})


def test_fields_are_attributes(message):
    decoded = MessageDecoder().Decode(message)
    assert tuple(decoded.name) == LOG.joints.names
    assert list(decoded.position) == LOG.joints.positions[0].tolist()
    stamp = decoded.header.stamp
    assert stamp.sec * 10**9 + stamp.nanosec == LOG.start_time


def test_a_compressed_message_is_unpacked(message):
    packed = _changed(message, data=zstandard.compress(message.data))
    decoder = MessageDecoder()
    assert list(decoder.Decode(packed).position) == list(
        decoder.Decode(message).position
    )


def test_a_message_that_claims_to_be_huge_is_refused(message):
    # A frame of zstd with a content of 2^40 bytes.
    header = b"\x28\xb5\x2f\xfd\xe0" + (2**40).to_bytes(8, "little")
    with pytest.raises(ValueError, match="too long"):
        MessageDecoder().Decode(_changed(message, data=header + b"\0" * 9))


@pytest.mark.parametrize("encoding", ["json", "protobuf", ""])
def test_another_encoding_is_refused(message, encoding):
    for _ in range(2):
        with pytest.raises(ValueError):
            MessageDecoder().Decode(_changed(message, encoding=encoding))


def test_a_ros2_type_that_never_changed_needs_no_definition(message):
    changed = _changed(message, definition="float64 y\nfloat64 x")
    if message.encoding == "cdr":
        decoded = MessageDecoder().Decode(changed)
        assert math.isfinite(decoded.position[0])
    else:
        with pytest.raises(Exception, match="mismatch|has no attribute|could"):
            MessageDecoder().Decode(changed)


def test_a_definition_is_checked_by_its_md5_sum():
    # That of ROS 1, as `rosmsg md5 std_msgs/Header` prints it.
    text = "uint32 seq\ntime stamp\nstring frame_id"
    checksum = "2176decaecbce78abc3b96ef049fabed"
    assert definition_matches("std_msgs/Header", text, checksum)
    assert definition_matches("std_msgs/Header", text, "*")
    damaged = text.replace("seq", "sex")
    assert not definition_matches("std_msgs/Header", damaged, checksum)
    assert not definition_matches("std_msgs/Header", "\0?", checksum)
