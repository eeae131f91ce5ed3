import logging

import pytest

from pbpf_drake.filtering.slow_updates import LateUpdates


class _Clock:
    def __init__(self):
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def test_updates_within_the_period_are_counted_and_not_told(caplog):
    dut = LateUpdates(0.16)
    for seconds in (0.01, 0.159, 0.16):
        dut.AddUpdate(seconds)
    assert (dut.updates, dut.late) == (3, 0)
    assert not caplog.records


def test_a_late_update_is_told_with_its_numbers(caplog):
    dut = LateUpdates(0.16)
    dut.AddUpdate(0.02)
    dut.AddUpdate(0.25)
    assert (dut.updates, dut.late) == (2, 1)
    (record,) = caplog.records
    assert record.levelno == logging.WARNING
    for number in ("took 250 ms", "160 ms", "1 of 2"):
        assert number in record.getMessage()


@pytest.mark.parametrize("step, lines", [(0.1, 2), (1.0, 13), (6.0, 61)])
def test_there_is_at_most_one_line_in_five_seconds(caplog, step, lines):
    clock = _Clock()
    dut = LateUpdates(0.16, clock=clock)
    for _ in range(61):
        dut.AddUpdate(1.0)
        clock.now += step
    assert dut.late == 61
    assert len(caplog.records) == lines
