"""What streams of all kinds of files have in common."""

from bag_fixtures import our_entries, write_mcap, write_ros1, write_ros2
from log_fixtures import make_small_log
import pytest

from pbpf_drake.bags.log_container import OpenLogStream
from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_stream import OpenBytes

ENTRIES = our_entries(make_small_log())


@pytest.fixture(params=[write_mcap, write_ros1, write_ros2])
def path(request, tmp_path):
    return request.param(tmp_path / "log", ENTRIES)


def _topics(stream):
    return [message.topic for message in stream.Messages()]


def test_without_topics_all_messages_are_yielded(path):
    stream = OpenLogStream(path)
    assert sorted(_topics(stream)) == sorted(topic for _, topic, *_ in ENTRIES)
    assert stream.damage == []


def test_all_topics_are_known_whichever_are_wanted(path):
    stream = OpenLogStream(path, ["/joint_states", "/nowhere"])
    assert set(_topics(stream)) == {"/joint_states"}
    assert set(stream.types) == {topic for _, topic, *_ in ENTRIES}


def test_a_stream_of_no_topics_is_empty(path):
    stream = OpenLogStream(path, [])
    assert _topics(stream) == []
    assert stream.damage == []


def test_a_file_is_opened_only_if_it_has_bytes(tmp_path):
    path = tmp_path / "file"
    with pytest.raises(LogError, match="can't be opened: No such file"):
        OpenBytes(path)
    path.write_bytes(b"")
    with pytest.raises(LogError, match="it is empty"):
        OpenBytes(path)
    path.write_bytes(b"abc")
    with OpenBytes(path) as data:
        assert data[:] == b"abc"
