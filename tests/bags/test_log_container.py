"""The same log in every container is read as the same log."""

import os

from bag_fixtures import our_entries, write_mcap, write_ros1, write_ros2
from log_fixtures import assert_same_log, make_small_log, read_small_log
import pytest
import zstandard

from pbpf_drake.bags.log_container import OpenLogStream
from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.read_limits import ReadLimits

CONTAINERS = {
    "mcap": lambda path, e: write_mcap(path, e),
    "bag-none": lambda path, e: write_ros1(path, e, "none"),
    "bag-bz2": lambda path, e: write_ros1(path, e, "bz2"),
    "bag-lz4": lambda path, e: write_ros1(path, e, "lz4"),
    "sqlite-folder": lambda path, e: write_ros2(path, e),
    "sqlite-message": lambda path, e: write_ros2(
        path, e, compression="message"
    ),
    "sqlite-file": lambda path, e: write_ros2(path, e, compression="file"),
    "mcap-folder": lambda path, e: write_ros2(
        path, e, storage="mcap", compression="storage"
    ),
}


@pytest.mark.parametrize("name", CONTAINERS)
def test_a_log_is_the_same_in_every_container(tmp_path, name):
    log = make_small_log()
    path = CONTAINERS[name](tmp_path / "log", our_entries(log))
    found = read_small_log(path)
    assert found.warnings == ()
    assert_same_log(found, log)


def test_the_file_of_a_folder_can_be_read_alone(tmp_path):
    log = make_small_log()
    write_ros2(tmp_path / "log", our_entries(log))
    found = read_small_log(tmp_path / "log" / "log.db3")
    assert found.warnings == ()
    assert_same_log(found, log)


def test_limits_are_those_that_are_asked_for(tmp_path):
    path = write_mcap(tmp_path / "log", our_entries(make_small_log()))
    stream = OpenLogStream(path, limits=ReadLimits(message=100))
    assert {m.topic for m in stream.Messages()} == {"/ground_truth/box"}
    assert any("see ReadLimits.message" in said for said in stream.damage)


def test_what_a_file_is_is_told_by_its_content_not_its_name(tmp_path):
    path = tmp_path / "log.mcap"
    write_ros1(path, our_entries(make_small_log()))
    assert OpenLogStream(path).kind == "a ROS 1 bag"
    assert read_small_log(path).warnings == ()


def test_a_log_that_is_compressed_as_a_whole_is_read(tmp_path):
    log = make_small_log(num_samples=3000)
    whole = write_ros1(tmp_path / "log", our_entries(log)).read_bytes()
    packed = tmp_path / "log.bag.zstd"
    packed.write_bytes(zstandard.compress(whole))
    found = read_small_log(packed)
    assert found.warnings == ()
    assert_same_log(found, log)
    # Of one that is cut off the beginning is used.
    packed.write_bytes(packed.read_bytes()[: packed.stat().st_size * 3 // 4])
    found = read_small_log(packed)
    assert 1000 < len(found.joints.times) < 3000
    assert any("cut off" in warning for warning in found.warnings)


@pytest.mark.parametrize("name", ["log.db3", "log.mcap"])
def test_a_file_of_nothing_is_refused(tmp_path, name):
    path = tmp_path / name
    path.write_bytes(b"")
    with pytest.raises(LogError, match="it is empty"):
        read_small_log(path)


def test_a_pipe_is_refused_without_waiting_for_it(tmp_path):
    path = tmp_path / "log.mcap"
    os.mkfifo(path)
    with pytest.raises(LogError, match="but it is no regular file"):
        OpenLogStream(path)
