"""ROS 2 bags in SQLite, of all ages, and damaged ones."""

from itertools import islice
import sqlite3

from bag_fixtures import our_entries, write_ros2
from damage_fixtures import count_wrong, expected_log
from log_fixtures import has_warning, read_small_log
import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.sqlite_bag_stream import SqliteBagStream

PAGE = 4096


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bag") / "log"
    write_ros2(folder, our_entries(expected_log()))
    return (folder / "log.db3").read_bytes()


@pytest.fixture
def file(tmp_path, whole):
    path = tmp_path / "log.db3"
    path.write_bytes(whole)
    return path


def _change(path, *commands):
    with sqlite3.connect(path) as database:
        for command in commands:
            database.execute(command)
    database.close()


def test_a_bag_of_humble_or_older_has_no_definitions(file):
    _change(
        file,
        "DROP TABLE message_definitions",
        "DROP TABLE schema",
        "DROP TABLE metadata",
    )
    log = read_small_log(file)
    assert log.warnings == ()
    assert count_wrong(log, expected_log()) == 0
    assert len(log.detections) == len(expected_log().detections)


def test_a_damaged_page_costs_the_messages_on_it(file, whole):
    # The content of leaves with messages starts with their kind, 13.
    leaves = [
        at
        for at in range(PAGE, len(whole), PAGE)
        if whole[at] == 13 and b"\0\1\0\0" in whole[at + 200 : at + PAGE]
    ]
    content = bytearray(whole)
    content[leaves[3]] = 77
    file.write_bytes(content)
    log = read_small_log(file)
    assert 120 < len(log.joints.times) < 150
    assert has_warning(log, "left out the messages")
    assert count_wrong(log, expected_log()) == 0


@pytest.mark.parametrize("share", [0.5, 0.6, 0.8])
def test_a_file_that_is_cut_off_is_used_up_to_there(file, whole, share):
    length = int(share * len(whole))
    file.write_bytes(whole[:length])
    log = read_small_log(file)
    assert 20 < len(log.joints.times) < 150
    expected = f"cut off: it has {length} of {len(whole)} bytes"
    assert has_warning(log, expected)
    assert has_warning(log, "no checksums")
    assert count_wrong(log, expected_log()) == 0


def test_another_database_is_refused(tmp_path):
    path = tmp_path / "cookies.sqlite"
    _change(path, "CREATE TABLE cookies (id INTEGER)")
    with pytest.raises(LogError, match="without the topics of a ROS 2 bag"):
        read_small_log(path)


def test_what_is_no_row_of_a_bag_is_left_out(file):
    _change(
        file,
        "UPDATE messages SET data = 'text' WHERE id = 4",
        "UPDATE messages SET timestamp = 'soon' WHERE id = 7",
        "UPDATE messages SET topic_id = 99 WHERE id = 9",
    )
    log = read_small_log(file)
    assert has_warning(log, "left out 2 messages: damaged")
    assert has_warning(log, "1 message of an unknown topic")
    assert count_wrong(log, expected_log()) == 0


def test_a_topic_with_a_name_that_can_not_be_is_said(file, whole):
    at = whole.index(b"/ground_truth/boxgeometry_msgs")
    file.write_bytes(whole[:at] + b"\xd8" + whole[at + 1 :])
    log = read_small_log(file)
    assert log.ground_truth == {}
    assert has_warning(log, "left out the topic")


def test_what_a_recorder_left_in_its_journal_is_read(tmp_path, whole):
    path = tmp_path / "live" / "log.db3"
    path.parent.mkdir()
    path.write_bytes(whole)
    recorder = sqlite3.connect(path)
    recorder.execute("PRAGMA journal_mode = WAL")
    recorder.execute("DELETE FROM messages WHERE id > 200")
    recorder.commit()
    try:
        count = len(read_small_log(path).joints.times)
    finally:
        recorder.close()
    assert count < 150


def _lead_in_a_circle(whole):
    """The content, in which one leaf is twice there, and the next is bad."""
    content = bytearray(whole)
    for at in range(PAGE, len(whole), PAGE):
        count = int.from_bytes(content[at + 3 : at + 5], "big")
        if content[at] == 5 and count > 5:
            break
    # Cells of an inner page start with the number of a page below it.
    places = [
        at + int.from_bytes(content[at + 12 + 2 * i :][:2], "big")
        for i in range(count)
    ]
    first, third, fourth = (places[i] for i in (0, 3, 4))
    content[third : third + 4] = content[first : first + 4]
    bad = int.from_bytes(content[fourth : fourth + 4], "big")
    content[(bad - 1) * PAGE] = 77
    return bytes(content)


def test_rows_that_lead_in_a_circle_end(file, whole):
    file.write_bytes(_lead_in_a_circle(whole))
    stream = SqliteBagStream(filename=file)
    read = list(islice(stream.Messages(), 2000))
    assert 150 < len(read) < 265
    # No message is there twice.
    assert len({(m.topic, m.log_time) for m in read}) == len(read)
    assert stream.damage[0].startswith("left out the messages 77 to 129")
    log = read_small_log(file)
    assert count_wrong(log, expected_log()) == 0


def test_many_places_that_are_damaged_are_counted_not_named(file):
    _change(file, "UPDATE topics SET name = 'a b'")
    rows = "), (".join(f"{i}, 'a b', 'x', 'cdr', '', ''" for i in range(9, 99))
    _change(file, f"INSERT INTO topics VALUES ({rows})")
    stream = SqliteBagStream(filename=file)
    assert list(stream.Messages()) == []
    assert len(stream.damage) < 40
    assert "left out 63 more places: damaged" in stream.damage
