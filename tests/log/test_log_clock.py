"""When messages were, and when they were received."""

import pytest

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.log_clock import find_clock
from pbpf_drake.log.log_samples import RawStamped

SECOND = 10**9
# A time of a real clock (in nanoseconds).
T0 = 1_700_000_000 * SECOND


def _stamp(joints, detections=()):
    """Returns notes, and (time, received) of both in seconds after T0."""
    notes = LogNotes()
    raw = {
        topic: [RawStamped(log_time, stamp, None) for log_time, stamp in pairs]
        for topic, pairs in (("j", joints), ("d", detections))
    }
    clock = find_clock(raw["j"], notes)
    return [
        [
            (m.time, m.received)
            for m in clock.Place(messages, notes.On(topic, "message"))
        ]
        for topic, messages in raw.items()
    ] + [notes.Sentences()]


def test_a_message_is_received_at_its_log_time_but_not_before_its_stamp():
    joints, detections, notes = _stamp(
        [(T0 + 10, T0)], [(T0 + 300, T0 + 100), (T0 + 400, T0 + 500)]
    )
    assert joints == [(T0, T0 + 10)]
    assert detections == [(T0 + 100, T0 + 300), (T0 + 500, T0 + 500)]
    assert notes == ()


def test_messages_are_returned_as_they_were_received():
    joints, _, _ = _stamp([(T0 + 2, T0 + 1), (T0 + 1, T0 + 3), (T0 + 3, T0)])
    assert [received for _, received in joints] == [T0 + 3, T0 + 2, T0 + 3]
    assert [time for time, _ in joints] == [T0 + 3, T0 + 1, T0]


def test_a_message_without_a_stamp_gets_its_log_time():
    joints, detections, notes = _stamp([(T0, 0), (T0 + 5, 0)], [(T0 + 3, 0)])
    assert joints == [(T0, T0), (T0 + 5, T0 + 5)]
    assert detections == [(T0 + 3, T0 + 3)]
    assert notes == ()


def test_one_missing_stamp_among_others_is_filled_in():
    joints, _, _ = _stamp([(T0, T0 - 2), (T0 + 5, 0), (T0 + 9, T0 + 7)])
    assert [time for time, _ in joints] == [T0 - 2, T0 + 5, T0 + 7]


def test_stamps_of_a_simulated_clock_are_used_alone():
    joints, detections, notes = _stamp(
        [(T0 + i * SECOND, i * SECOND // 2) for i in range(1, 6)],
        [(T0 + 4 * SECOND, SECOND), (T0 + 3 * SECOND, 0)],
    )
    assert joints == [(i * SECOND // 2,) * 2 for i in range(1, 6)]
    # The one without a stamp: half of the real time, as the joints' median.
    assert detections == [(3 * SECOND // 2,) * 2, (SECOND,) * 2]
    (note,) = notes
    assert "of another clock" in note


@pytest.mark.parametrize("stamp", [1, 2**32 * SECOND, T0 - 4000 * SECOND])
def test_a_stamp_far_off_is_left_out(stamp):
    joints, detections, notes = _stamp(
        [(T0, T0), (T0 + 5, stamp), (T0 + 9, T0 + 9)], [(T0 + 7, stamp)]
    )
    assert [time for time, _ in joints] == [T0, T0 + 9]
    assert detections == []
    assert notes == (
        "j: left out 1 message whose stamp is more than an hour off the log "
        "time",
        "d: left out 1 message whose stamp is more than an hour off the log "
        "time",
    )
