"""The records of an MCAP file, whole and damaged."""

import struct
import zlib

from bomb_fixtures import mcap_chunk
from mcap.opcode import Opcode
import pytest

from pbpf_drake.bags.mcap_records import (
    MCAP_MAGIC,
    RECORD_HEADER,
    check_records,
    cut_chunk,
    find_summary,
    parse_chunk,
    parse_message,
    parse_record,
    walk_records,
)

CONTENT = b"records"
CHUNK = mcap_chunk(b"", CONTENT, len(CONTENT))


def _record(opcode, content):
    return RECORD_HEADER.pack(opcode, len(content)) + content


def _inside(record):
    return memoryview(record)[RECORD_HEADER.size :]


def test_whole_records_are_walked_up_to_the_first_that_is_not():
    records = _record(7, b"abc") + _record(8, b"")
    places = list(walk_records(records + b"\7\7\7", 0))
    assert [(p.opcode, p.end - p.begin) for p in places] == [(7, 3), (8, 0)]
    assert places[-1].end == len(records)


def test_after_damage_it_goes_on_at_a_known_chunk():
    damaged = b"\7" + b"\xff" * 8 + b"..."
    content = damaged + CHUNK
    assert list(walk_records(content, 0)) == []
    (place,) = walk_records(content, 0, [len(damaged)])
    assert place.opcode == Opcode.CHUNK


def test_a_message_is_a_part_of_its_record():
    content = struct.pack("<HIQQ", 3, 1, 55, 66) + b"data"
    message = parse_message(memoryview(content))
    assert (message.channel_id, message.log_time) == (3, 55)
    assert message.data == b"data"
    with pytest.raises(struct.error):
        parse_message(memoryview(content[:20]))


def test_a_chunk_is_checked_by_its_checksum_or_its_length():
    chunk = parse_chunk(_inside(CHUNK))
    assert chunk.packed == CONTENT and chunk.missing == 0
    check_records(chunk, CONTENT)
    with pytest.raises(ValueError, match="length"):
        check_records(chunk, CONTENT + b".")
    with_crc = bytearray(_inside(CHUNK))
    with_crc[24:28] = struct.pack("<I", zlib.crc32(CONTENT))
    chunk = parse_chunk(memoryview(with_crc))
    check_records(chunk, CONTENT)
    with pytest.raises(ValueError, match="checksum"):
        check_records(chunk, CONTENT[::-1])


def test_a_chunk_is_cut_off_where_both_lengths_say_so():
    view = memoryview(CHUNK[:-3])
    chunk = cut_chunk(view, 0)
    assert chunk.packed == CONTENT[:-3] and chunk.missing == 3
    assert cut_chunk(memoryview(CHUNK), 0) is None
    assert cut_chunk(view[:20], 0) is None
    longer = bytearray(CHUNK[:-3])
    longer[1] += 1
    assert cut_chunk(memoryview(longer), 0) is None


def test_records_of_no_use_are_not_parsed():
    assert parse_record(0x77, memoryview(b"anything")) is None


def test_a_file_without_an_end_has_no_summary():
    assert find_summary(b"") is None
    assert find_summary(MCAP_MAGIC * 10) is None
