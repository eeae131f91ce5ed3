"""Walking the records of a bag, whole and damaged."""

import struct

import pytest

from pbpf_drake.bags.ros1_records import (
    CONNECTION,
    MESSAGE,
    Record,
    index_entries,
    parse_fields,
    walk_records,
)


def _block(content: bytes) -> bytes:
    return struct.pack("<I", len(content)) + content


def _record(kind: int, data: bytes, **fields: bytes) -> bytes:
    """A record by the format's specification."""
    header = _block(b"op=" + bytes([kind]))
    for name, value in fields.items():
        header += _block(name.encode() + b"=" + value)
    return _block(header) + _block(data)


_RECORDS = [
    _record(
        MESSAGE, bytes([i]) * 10, conn=b"\1\0\0\0", time=b"\2\0\0\0\3\0\0\0"
    )
    for i in range(4)
]
_STARTS = [i * len(_RECORDS[0]) for i in range(4)]


def _walk(content, starts=()):
    lost = []
    records = list(
        walk_records(
            content,
            begin=0,
            end=len(content),
            starts=starts,
            lost=lambda begin, end: lost.append((begin, end)),
        )
    )
    return records, lost


def test_whole_records_are_walked():
    records, lost = _walk(b"".join(_RECORDS))
    assert [r.begin for r in records] == _STARTS and not lost
    assert [r.data for r in records] == [bytes([i]) * 10 for i in range(4)]
    assert records[0].Number("conn") == 1
    assert records[0].Number("size") == -1
    assert records[0].Time() == 2_000_000_003


@pytest.mark.parametrize("value", [0, 5, 60, 255])
@pytest.mark.parametrize("offset", [0, 1, 3, 4, 8, 11])
def test_damage_costs_one_record_where_starts_are_known(value, offset):
    content = bytearray(b"".join(_RECORDS))
    content[_STARTS[1] + offset] = value
    records, lost = _walk(bytes(content), _STARTS)
    kept = [r.begin for r in records]
    assert set(_STARTS) - {_STARTS[1]} <= set(kept) <= set(_STARTS)
    assert (_STARTS[1] in kept) != bool(lost)


def test_without_known_starts_the_rest_is_lost():
    content = bytearray(b"".join(_RECORDS))
    content[_STARTS[1] + 3] = 0x7F
    records, lost = _walk(bytes(content))
    assert len(records) == 1
    assert lost == [(_STARTS[1], len(content))]


def test_a_start_that_is_wrong_does_no_harm():
    starts = sorted([*_STARTS, 7, _STARTS[2] + 1, 10**9])
    records, lost = _walk(b"".join(_RECORDS), starts)
    assert len(records) == 4 and not lost


@pytest.mark.parametrize("header", [b"\1", b"\4\0\0\0a=", b"\2\0\0\0ab"])
def test_a_damaged_header_is_refused(header):
    with pytest.raises(ValueError):
        parse_fields(header)


def test_an_index_may_end_in_half_an_entry():
    fields = {"conn": b"\5\0\0\0"}
    data = struct.pack("<III", 1, 2, 77) + b"\1\2"
    record = Record(CONNECTION, fields, data, 0, 0)
    assert list(index_entries(record)) == [(5, 1_000_000_002, 77)]
