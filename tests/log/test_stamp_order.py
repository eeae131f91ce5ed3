"""Messages are put in the order of their stamps."""

from log_fixtures import has_warning
from mcap_fixtures import SECOND, T0
import numpy as np

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.log_samples import Stamped
from pbpf_drake.log.stamp_order import gap_clause, in_stamp_order, seconds_since


def _order(*times):
    """Returns the times with their places in the input, and the notes."""
    notes = LogNotes()
    messages = [Stamped(t, 100 + i, i) for i, t in enumerate(times)]
    kept = in_stamp_order(messages, notes.On("/a", "message"))
    return [(m.time, m.value) for m in kept], notes.Sentences()


def test_messages_in_order_are_left_alone():
    assert _order(3, 5, 9) == ([(3, 0), (5, 1), (9, 2)], ())


def test_of_equal_stamps_the_first_received_is_kept():
    kept, notes = _order(5, 3, 5, 3)
    assert kept == [(3, 1), (5, 0)]
    assert notes == (
        "/a: put in order 2 messages with an earlier stamp",
        "/a: left out 2 messages with the stamp of an earlier one",
    )


def test_seconds_are_relative_to_the_start():
    messages = [Stamped(T0 + t, 0, None) for t in (-SECOND, 0, SECOND // 4)]
    assert seconds_since(T0, messages).tolist() == [-1.0, 0.0, 0.25]


def test_stamps_are_sorted_and_duplicates_left_out(faulty):
    for i, time in enumerate([0.0, 0.2, 0.1, 0.3, 0.2]):
        stamp = T0 + round(time * SECOND)
        faulty.joints(0.1 * i, positions=(i, 0), stamp=stamp)
    log = faulty.read()
    assert log.joints.times.tolist() == [0.0, 0.1, 0.2, 0.3]
    assert log.joints.positions[:, 0].tolist() == [0, 2, 1, 3]
    assert has_warning(log, "put in order 2 messages")
    assert has_warning(
        log, "left out 1 message with the stamp of an earlier one"
    )


def test_gaps_are_told_with_the_longest():
    steps = np.full(60, 0.1)
    assert gap_clause(np.cumsum(steps)) == ""
    steps[[10, 30]] = 1.5, 3.0
    said = gap_clause(np.cumsum(steps))
    assert said == (
        "there are 2 gaps without messages, the longest of 3.00 s from 4.40 s "
        "on"
    )


def test_a_topic_at_a_low_rate_has_no_gaps():
    assert gap_clause(np.arange(10) * 2.0) == ""
    assert gap_clause(np.array([0.0])) == gap_clause(np.array([])) == ""
