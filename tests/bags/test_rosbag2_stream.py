"""ROS 2 recordings that are folders."""

import shutil

from bag_fixtures import our_entries, write_mcap, write_ros2
from log_fixtures import has_warning, make_small_log, read_small_log
import pytest

from pbpf_drake.bags.log_error import LogError

LOG = make_small_log()


@pytest.fixture(params=["sqlite3", "mcap"])
def folder(request, tmp_path):
    return write_ros2(tmp_path / "log", our_entries(LOG), storage=request.param)


def test_without_metadata_all_files_are_read_and_it_is_said(folder):
    (folder / "metadata.yaml").unlink()
    log = read_small_log(folder)
    assert len(log.joints.times) == len(LOG.joints.times)
    (warning,) = log.warnings
    assert "metadata.yaml can't be used (there is none)" in warning


@pytest.mark.parametrize("text", ["", "- 1", "{", "a: b\n", "\0"])
def test_damaged_metadata_is_no_more_than_missing(folder, text):
    (folder / "metadata.yaml").write_text(text)
    log = read_small_log(folder)
    assert len(log.joints.times) == len(LOG.joints.times)
    assert "metadata.yaml can't be used" in log.warnings[0]


def test_a_recording_that_was_split_is_read_as_one(tmp_path):
    entries = our_entries(LOG)
    folder = tmp_path / "log"
    folder.mkdir()
    write_mcap(folder / "log_0.mcap", entries[:40])
    write_mcap(folder / "log_1.mcap", entries[40:])
    log = read_small_log(folder)
    assert len(log.joints.times) == len(LOG.joints.times)
    assert len(log.warnings) == 1


def test_a_file_that_is_missing_is_said(folder, tmp_path):
    name = next(f.name for f in folder.iterdir() if f.suffix != ".yaml")
    text = (folder / "metadata.yaml").read_text()
    text = text.replace(f"- {name}", f"- {name}\n  - lost{name}", 1)
    (folder / "metadata.yaml").write_text(text)
    log = read_small_log(folder)
    assert len(log.joints.times) == len(LOG.joints.times)
    assert has_warning(log, f"lost{name}: it can't be opened")


def test_fewer_messages_than_metadata_promises_are_said(folder):
    path = folder / "metadata.yaml"
    text = path.read_text().replace("message_count: 50", "message_count: 51")
    path.write_text(text)
    assert has_warning(
        read_small_log(folder),
        "/joint_states has 51 messages, but 50 could be read",
    )


def test_a_folder_whose_files_are_all_unreadable_is_refused(folder):
    for file in folder.iterdir():
        if file.suffix != ".yaml":
            file.write_bytes(b"nothing")
    with pytest.raises(LogError, match="expected an MCAP file.*b'nothing'"):
        read_small_log(folder)
    shutil.rmtree(folder)
    with pytest.raises(LogError, match="can't be opened"):
        read_small_log(folder)
