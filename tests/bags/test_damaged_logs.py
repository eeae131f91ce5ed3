"""Files damaged at random: refused or read, and what is missing is said."""

import resource
import time

from damage_fixtures import (
    CONTAINERS,
    KINDS,
    PACKED_AS_A_WHOLE,
    PROTECTED,
    count_wrong,
    damage,
    expected_log,
    is_whole,
    write_container,
)
from log_fixtures import read_small_log
import pytest

from pbpf_drake.bags.log_error import LogError

# Damaged copies of each container; the slow tests have 2,000 in all.
FEW, MANY = 3 * len(KINDS), 25 * len(KINDS)
# What reading one of them may take (in seconds of the processor, and kB).
MAX_TIME, MAX_MEMORY = 5.0, 10**6


@pytest.fixture(
    scope="module",
    params=[
        pytest.param((name, count), id=f"{name}-{count}", marks=marks)
        for count, marks in ((FEW, ()), (MANY, pytest.mark.slow))
        for name in CONTAINERS
    ],
)
def damaged(request, tmp_path_factory):
    """The container's name, and seed, kind of damage and log or None."""
    name, count = request.param
    path = tmp_path_factory.mktemp("damage") / "whole"
    whole = write_container(name, path)
    content, copy = whole.read_bytes(), path.with_name("damaged")
    logs = []
    for seed in range(count):
        kind = KINDS[seed % len(KINDS)]
        copy.write_bytes(damage(content, kind, seed))
        start = time.process_time()
        try:
            log = read_small_log(copy)
        except LogError as error:
            assert "\n" not in str(error) and str(copy) in str(error)
            log = None
        assert time.process_time() - start < MAX_TIME, seed
        logs.append((seed, kind, log))
    return name, logs


def test_what_is_missing_is_said(damaged):
    for seed, _, log in damaged[1]:
        if log is not None and not is_whole(log, expected_log()):
            assert log.warnings, seed


def test_numbers_are_right_where_there_are_checksums(damaged):
    name, logs = damaged
    for seed, kind, log in logs:
        # What is cut off changes nothing in what is left, in any file.
        if log is not None and (name in PROTECTED or kind == "cut"):
            assert count_wrong(log, expected_log()) == 0, seed


def test_one_byte_costs_no_more_than_one_number_without_checksums(damaged):
    name, logs = damaged
    if name in PACKED_AS_A_WHOLE:
        return  # One byte may change all that follows it.
    for seed, kind, log in logs:
        if log is not None and kind == "one byte":
            assert count_wrong(log, expected_log()) <= 1, seed


def test_what_is_whole_is_used(damaged):
    name, logs = damaged
    if name in PACKED_AS_A_WHOLE:
        return  # One byte may change all that follows it.
    cut = [log for _, kind, log in logs if kind == "cut"]
    changed = [log for _, kind, log in logs if kind == "one byte"]
    assert sum(log is not None for log in changed) >= len(changed) - 2
    lengths = [len(log.joints.times) for log in changed if log]
    assert sum(lengths) > 0.8 * 150 * len(lengths)
    # Cuts are anywhere; what comes before a message may be half of a file.
    assert sum(log is not None for log in cut) >= len(cut) // 3


def test_no_file_takes_much_memory(damaged):
    assert damaged[1]
    # What all tests of this process have taken at most.
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 2 * MAX_MEMORY
