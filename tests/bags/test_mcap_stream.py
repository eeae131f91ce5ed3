"""Damaged files: what is whole is used, and nothing is wrong silently."""

from bag_fixtures import copy_mcap, our_entries, write_mcap
from log_fixtures import (
    has_warning,
    make_small_log,
    make_small_scene,
    read_small_log,
)
from mcap.writer import CompressionType, Writer
import numpy as np
import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.mcap_stream import McapStream
from pbpf_drake.log import mcap_log_writer
from pbpf_drake.log.mcap_log_writer import WriteLog

CHUNK, MESSAGE_INDEX = 0x06, 0x07


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The bytes of a log in about ten chunks."""
    path = tmp_path_factory.mktemp("whole") / "log.mcap"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mcap_log_writer, "CHUNK_SIZE", 4000)
        WriteLog(
            filename=path,
            scene_topics=make_small_scene().topics,
            log=make_small_log(num_samples=150),
        )
    return path.read_bytes()


def _records(content):
    """Opcode and place of every record, by the format's specification."""
    found, at = [], 8
    while at < len(content) - 8:
        length = int.from_bytes(content[at + 1 : at + 9], "little")
        found.append((content[at], at, at + 9 + length))
        at += 9 + length
    return found


def _chunks(content):
    return [
        (at, end) for opcode, at, end in _records(content) if opcode == CHUNK
    ]


def _read(path, content):
    path.write_bytes(content)
    return read_small_log(path)


def _assert_part_of(log, expected):
    """Every number in the log is one of the expected log's."""
    start = (log.start_time - expected.start_time) / 1e9
    for found, whole, fields in [
        (log.joints, expected.joints, ("positions", "velocities")),
        (
            log.ground_truth.get("box"),
            expected.ground_truth["box"],
            ("q_WO", "p_WO"),
        ),
    ]:
        if found is None:
            continue
        times = np.round(found.times + start, 9)
        rows = np.searchsorted(whole.times, times - 1e-9)
        np.testing.assert_allclose(whole.times[rows], times, atol=1e-9)
        for field in fields:
            np.testing.assert_array_equal(
                getattr(found, field), getattr(whole, field)[rows]
            )
    by_time = {round(d.time, 6): d for d in expected.detections}
    for detection in log.detections:
        match = by_time[round(detection.time + start, 6)]
        assert detection.X_CO.IsNearlyEqualTo(match.X_CO, 1e-14)


def _flip(content, at, mask=0xFF):
    damaged = bytearray(content)
    damaged[at] ^= mask
    return bytes(damaged)


def test_a_whole_file_has_no_damage(whole, tmp_path):
    assert len(_chunks(whole)) >= 8
    assert _read(tmp_path / "log", whole).warnings == ()


def test_all_topics_are_known_and_only_those_asked_for_are_returned(
    whole, tmp_path
):
    path = tmp_path / "log"
    path.write_bytes(whole)
    stream = McapStream(filename=path, topics=["/joint_states"])
    topics = {m.topic for m in stream.Messages()}
    assert topics == {"/joint_states"}
    assert stream.types == {
        "/joint_states": "sensor_msgs/msg/JointState",
        "/dope/detected_objects": "vision_msgs/msg/Detection3DArray",
        "/ground_truth/box": "geometry_msgs/msg/PoseStamped",
    }
    assert stream.damage == []


@pytest.mark.parametrize("fraction", [0.3, 0.5, 0.7])
def test_a_truncated_file_is_used_up_to_its_last_whole_chunk(
    whole, tmp_path, fraction
):
    length = int(fraction * len(whole))
    log = _read(tmp_path / "log", whole[:length])
    complete = sum(end <= length for _, end in _chunks(whole))
    share = complete / len(_chunks(whole))
    assert len(log.joints.times) == pytest.approx(150 * share, abs=16)
    (warning,) = log.warnings
    assert "the file is cut off" in warning and f"of {length}" in warning
    _assert_part_of(log, make_small_log(num_samples=150))


@pytest.mark.parametrize("missing", [1, 100, 1000])
def test_a_file_cut_off_after_its_messages_says_so(whole, tmp_path, missing):
    log = _read(tmp_path / "log", whole[:-missing])
    assert len(log.joints.times) == 150
    (warning,) = log.warnings
    assert "the file is cut off after its last message" in warning


def test_a_file_cut_off_in_its_first_chunk_has_no_joint_states(whole, tmp_path):
    at, end = _chunks(whole)[0]
    with pytest.raises(LogError, match="no joint states.*the file is cut off"):
        _read(tmp_path / "log", whole[: (at + end) // 2])


@pytest.mark.parametrize("index", [0, 3, -1])
def test_a_damaged_chunk_costs_only_itself(whole, tmp_path, index):
    at, end = _chunks(whole)[index]
    log = _read(tmp_path / "log", _flip(whole, (at + end) // 2))
    assert 120 < len(log.joints.times) < 150
    assert "left out 1 chunk: damaged" in log.warnings
    assert has_warning(log, "/joint_states has 150 messages, but")
    _assert_part_of(log, make_small_log(num_samples=150))


def test_a_chunk_that_is_taken_for_something_else_is_missed(whole, tmp_path):
    # An unknown kind of record has to be skipped: only the count tells.
    at, _ = _chunks(whole)[2]
    log = _read(tmp_path / "log", _flip(whole, at, 0x70))
    assert has_warning(log, "but")
    _assert_part_of(log, make_small_log(num_samples=150))


def test_an_index_is_not_needed(whole, tmp_path):
    damaged = whole
    for opcode, at, end in _records(whole):
        if opcode == MESSAGE_INDEX:
            damaged = _flip(damaged, (at + 9 + end) // 2)
    assert _read(tmp_path / "log", damaged).warnings == ()


def test_data_outside_of_chunks_is_checked(tmp_path):
    path = tmp_path / "log"
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=False, enable_data_crcs=True)
        writer.start()
        channel = writer.register_channel("/topic", "cdr", 0)
        for i in range(5):
            writer.add_message(channel, i, b"payload!", i)
        writer.finish()
    for damaged in (False, True):
        if damaged:
            content = path.read_bytes()
            at = content.index(b"payload!")
            path.write_bytes(_flip(content, at))
        stream = McapStream(filename=path, topics=["/topic"])
        assert len(list(stream.Messages())) == 5
        assert len(stream.damage) == damaged
    assert "checksum of the file is wrong" in stream.damage[0]


@pytest.mark.parametrize("seed", range(100))
def test_random_damage_is_refused_or_said(whole, tmp_path, seed):
    rng = np.random.default_rng(seed)
    damaged = bytearray(whole)
    kind = seed % 4
    if kind == 0:
        damaged = damaged[: rng.integers(len(whole))]
    elif kind == 1:
        damaged[rng.integers(len(whole))] ^= 1 << rng.integers(8)
    elif kind == 2:
        # Where it hurts: the kind and the length of a record.
        starts = [at for _, at, _ in _records(whole)]
        damaged[rng.choice(starts) + rng.integers(9)] = rng.integers(256)
    else:
        for at in rng.integers(8, len(whole), 20):
            damaged[at] = rng.integers(256)
    expected = make_small_log(num_samples=150)
    try:
        log = _read(tmp_path / "log", bytes(damaged))
    except LogError:
        return
    _assert_part_of(log, expected)
    if not log.warnings:
        assert len(log.joints.times) == 150
        assert len(log.detections) == len(expected.detections)
        assert len(log.ground_truth["box"].times) == 100


@pytest.mark.parametrize("compression", list(CompressionType))
def test_a_chunk_that_is_cut_off_is_used_up_to_there(tmp_path, compression):
    path, source = tmp_path / "log", tmp_path / "source"
    # The whole log in one chunk, of which three quarters are left.
    entries = our_entries(make_small_log(num_samples=3000))
    copy_mcap(
        write_mcap(source, entries),
        path,
        compression=compression,
        chunk_size=10**7,
    )
    content = path.read_bytes()
    ((begin, end),) = _chunks(content)
    log = _read(path, content[: (begin + 3 * end) // 4])
    assert 1500 < len(log.joints.times) < 3000
    assert has_warning(log, "of the chunk that is cut off", "its checksum")
    _assert_part_of(log, make_small_log(num_samples=3000))


def test_a_chunk_whose_lengths_do_not_agree_is_not_cut_off(whole, tmp_path):
    # Both lengths are inflated in the last chunk, but not by the same.
    at, end = _chunks(whole)[-1]
    damaged = bytearray(whole[:end])
    damaged[at + 3] += 1
    log = _read(tmp_path / "log", bytes(damaged))
    assert not has_warning(log, "of the chunk that is cut off")
    assert has_warning(log, "the file is cut off")


@pytest.mark.parametrize("crcs", [True, False])
def test_it_is_known_whether_a_file_has_checksums(tmp_path, crcs):
    entries = our_entries(make_small_log())
    source, path = write_mcap(tmp_path / "source", entries), tmp_path / "log"
    copy_mcap(source, path, enable_crcs=crcs, enable_data_crcs=False)
    stream = McapStream(filename=path)
    assert list(stream.Messages()) and stream.checksums == crcs
