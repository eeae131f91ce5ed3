from dataclasses import replace

from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, ReadLimits, megabytes


def test_limits_hold_what_cameras_and_recorders_write():
    image_of_8k = 7680 * 4320 * 3
    assert DEFAULT_LIMITS.message > image_of_8k
    assert DEFAULT_LIMITS.chunk >= 2 * DEFAULT_LIMITS.message


def test_a_large_file_may_hold_more_than_a_small_one():
    limits = ReadLimits(unpacked=100, growth=2, records=10, bytes_per_record=5)
    assert limits.max_unpacked(10) == 100 and limits.max_unpacked(80) == 160
    assert limits.max_records(10) == 10 and limits.max_records(100) == 20
    limits = replace(limits, decoded=100, decoded_growth=3)
    assert limits.max_decoded(10) == 100 and limits.max_decoded(50) == 150


def test_what_a_file_unpacks_to_may_hold_no_more_than_the_file():
    inner = ReadLimits(unpacked=100, growth=2).of_file(80)
    assert inner.max_unpacked(10**6) == 160
    assert inner.max_records(10**12) == DEFAULT_LIMITS.records
    assert inner.max_decoded(10**12) == DEFAULT_LIMITS.decoded


def test_bytes_are_said_in_megabytes():
    assert megabytes(12_345_678) == "12.35 MB"
