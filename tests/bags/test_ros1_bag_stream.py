"""What damage costs in a ROS 1 bag, and what is said of it."""

import bag_fixtures
from bag_fixtures import our_entries, write_ros1
from damage_fixtures import count_wrong, expected_log
from log_fixtures import has_warning, make_small_log, read_small_log
import pytest

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.ros1_records import BAG_MAGIC, CHUNK, INDEX, walk_records


@pytest.fixture(scope="module", params=["none", "bz2"])
def whole(request, tmp_path_factory):
    """The bytes of a bag of about ten chunks."""
    path = tmp_path_factory.mktemp("bag") / "log.bag"
    write_ros1(path, our_entries(expected_log()), request.param)
    return path.read_bytes()


def _records(content, kind):
    return [
        record
        for record in walk_records(
            content,
            begin=len(BAG_MAGIC),
            end=len(content),
            starts=(),
            lost=lambda begin, end: pytest.fail("not whole"),
        )
        if record.kind == kind
    ]


def _read(tmp_path, content):
    path = tmp_path / "log.bag"
    path.write_bytes(content)
    return read_small_log(path)


def test_a_whole_bag_has_no_damage(whole, tmp_path):
    assert len(_records(whole, CHUNK)) > 5
    assert _read(tmp_path, whole).warnings == ()


@pytest.mark.parametrize("share", [0.4, 0.7])
def test_a_bag_that_was_broken_off_is_used_up_to_there(whole, tmp_path, share):
    length = int(share * len(whole))
    log = _read(tmp_path, whole[:length])
    complete = sum(r.end <= length for r in _records(whole, CHUNK))
    expected = 150 * complete / len(_records(whole, CHUNK))
    assert len(log.joints.times) == pytest.approx(expected, abs=25)
    assert has_warning(log, "the file has no index")
    assert has_warning(log, f"of {length}")
    assert count_wrong(log, expected_log()) == 0


def test_a_damaged_length_costs_one_chunk(whole, tmp_path):
    chunk = _records(whole, CHUNK)[2]
    damaged = bytearray(whole)
    damaged[chunk.begin + 3] = 0x7F
    log = _read(tmp_path, bytes(damaged))
    assert 110 < len(log.joints.times) < 150
    assert has_warning(log, f"left out bytes {chunk.begin} to ")
    assert has_warning(log, "1 chunk can't be found")
    assert count_wrong(log, expected_log()) == 0


def test_damage_within_a_chunk_costs_no_more_than_it(whole, tmp_path):
    chunk = _records(whole, CHUNK)[2]
    damaged = bytearray(whole)
    for at in range(chunk.end - 600, chunk.end - 500):
        damaged[at] ^= 0xFF
    log = _read(tmp_path, bytes(damaged))
    assert 110 < len(log.joints.times) < 150
    assert count_wrong(log, expected_log()) <= 1
    assert log.warnings


def test_a_message_that_the_index_knows_otherwise_is_left_out(whole, tmp_path):
    index = _records(whole, INDEX)[0]
    damaged = bytearray(whole)
    damaged[index.end - 8] ^= 1  # A time.
    log = _read(tmp_path, bytes(damaged))
    assert has_warning(log, "left out 1 message unlike its index")


def test_a_definition_with_a_wrong_checksum_is_not_used(whole, tmp_path):
    # Both copies: x and y of all positions would be exchanged.
    damaged = whole.replace(b"float64 x\nfloat64 y", b"float64 y\nfloat64 x")
    if damaged == whole:  # Those in chunks are compressed, and come first.
        return
    try:
        log = _read(tmp_path, damaged)
    except LogError:
        return
    assert count_wrong(log, expected_log()) == 0


def test_an_encrypted_bag_is_refused(whole, tmp_path):
    field = (len(b"encryptor=rot13")).to_bytes(4, "little") + b"encryptor=rot13"
    header = int.from_bytes(whole[13:17], "little")
    damaged = (
        whole[:13]
        + (header + len(field)).to_bytes(4, "little")
        + field
        + whole[17:]
    )
    with pytest.raises(LogError, match="it is encrypted, by b'rot13'"):
        _read(tmp_path, damaged)


@pytest.mark.parametrize("compression", ["none", "lz4"])
def test_a_chunk_that_is_cut_off_is_used_up_to_there(
    tmp_path, compression, monkeypatch
):
    # The whole log in one chunk, of which three quarters are left.
    monkeypatch.setattr(bag_fixtures, "_CHUNK", 10**7)
    expected = make_small_log(num_samples=3000)
    path = tmp_path / "whole"
    write_ros1(path, our_entries(expected), compression)
    content = path.read_bytes()
    log = _read(tmp_path, content[: len(content) * 3 // 4])
    assert 1000 < len(log.joints.times) < 3000
    assert has_warning(log, "of the chunk that is cut off", "its checksum")
    assert count_wrong(log, expected) == 0
