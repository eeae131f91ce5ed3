import pytest
import zstandard

from pbpf_drake.bags.read_budget import BudgetSpent, ReadBudget
from pbpf_drake.bags.read_limits import LimitError, ReadLimits

PACKED = zstandard.compress(bytes(1000))


def test_chunks_are_unpacked_until_the_file_has_held_enough():
    budget = ReadBudget(ReadLimits(chunk=2000, unpacked=3500, growth=0), 10)
    for _ in range(3):
        assert len(budget.Unpack("zstd", PACKED).content) == 1000
    with pytest.raises(BudgetSpent, match="ReadLimits.unpacked"):
        budget.Unpack("zstd", PACKED)


def test_a_chunk_that_is_too_long_is_no_end():
    budget = ReadBudget(ReadLimits(chunk=500, unpacked=10_000), 10)
    for _ in range(3):
        with pytest.raises(LimitError) as caught:
            budget.Unpack("zstd", PACKED)
        assert not isinstance(caught.value, BudgetSpent)


def test_what_is_not_packed_takes_nothing():
    budget = ReadBudget(ReadLimits(unpacked=10, growth=0), 10)
    for _ in range(3):
        assert len(budget.Unpack("", bytes(100)).content) == 100


def test_a_file_has_no_more_records_than_fit_in_it():
    budget = ReadBudget(ReadLimits(records=2, bytes_per_record=10), 30)
    for _ in range(3):
        budget.CountRecord()
    with pytest.raises(BudgetSpent, match="more than 3 records"):
        budget.CountRecord()
