"""Files damaged at random: refused or read, and what is missing is said."""

from bag_fixtures import our_entries, write_mcap, write_ros1, write_ros2
from damage_fixtures import count_wrong, damage, expected_log, is_whole
from log_fixtures import read_small_log
import pytest

from pbpf_drake.bags.log_error import LogError

# Damaged copies of each container; the slow tests have 2,000 in all.
FEW, MANY = 40, 400


def _sqlite(path, entries):
    return write_ros2(path, entries) / f"{path.name}.db3"


WRITERS = {
    "mcap": write_mcap,
    "bag-bz2": write_ros1,
    "bag-lz4": lambda path, entries: write_ros1(path, entries, "lz4"),
    "bag-none": lambda path, entries: write_ros1(path, entries, "none"),
    "sqlite": _sqlite,
}
# The others have no checksums: a changed digit can't be noticed.
PROTECTED = {"mcap", "bag-bz2", "bag-lz4"}


@pytest.fixture(
    scope="module",
    params=[
        pytest.param((name, count), id=f"{name}-{count}", marks=marks)
        for count, marks in ((FEW, ()), (MANY, pytest.mark.slow))
        for name in WRITERS
    ],
)
def damaged(request, tmp_path_factory):
    """The container's name, and seed, kind of damage and log or None."""
    name, count = request.param
    path = tmp_path_factory.mktemp("damage") / "whole"
    whole = WRITERS[name](path, our_entries(expected_log()))
    content, copy = whole.read_bytes(), path.with_name("damaged")
    logs = []
    for seed in range(count):
        copy.write_bytes(damage(content, seed))
        try:
            log = read_small_log(copy)
        except LogError as error:
            assert "\n" not in str(error) and str(copy) in str(error)
            log = None
        logs.append((seed, ("cut", "one byte", "some bytes")[seed % 3], log))
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
    for seed, kind, log in damaged[1]:
        if log is not None and kind == "one byte":
            assert count_wrong(log, expected_log()) <= 1, seed


def test_what_is_whole_is_used(damaged):
    logs = damaged[1]
    cut = [log for _, kind, log in logs if kind == "cut"]
    changed = [log for _, kind, log in logs if kind == "one byte"]
    assert sum(log is not None for log in changed) >= len(changed) - 2
    lengths = [len(log.joints.times) for log in changed if log]
    assert sum(lengths) > 0.8 * 150 * len(lengths)
    # Cuts are anywhere; what comes before a message may be half of a file.
    assert sum(log is not None for log in cut) >= len(cut) // 3
