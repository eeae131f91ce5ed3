"""All topics of a log are placed on one line of time."""

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.log_samples import RawStamped
from pbpf_drake.log.log_timeline import find_timeline

SECOND = 10**9
T0 = 1_700_000_000 * SECOND


def _raw(offset, stamps, value=None):
    """Messages that are logged so long after their stamps (in seconds)."""
    return [
        RawStamped(
            T0 + round((s + offset) * SECOND), T0 + round(s * SECOND), value
        )
        for s in stamps
    ]


def _timeline(reference):
    notes = LogNotes()
    return find_timeline(reference, notes), notes


def test_the_clock_is_that_of_the_stretch_that_is_used():
    # The second half is the first one once more, four seconds later.
    times = [0.1 * i for i in range(40)]
    reference = _raw(0.0, times) + _raw(4.0, [*times, 4.0])
    timeline, notes = _timeline(reference)
    placed = timeline.Place(_raw(4.5, [1.0]), notes.On("/d", "detection"))
    assert [m.time for m in placed] == [T0 + SECOND]
    # Log times and stamps seem to be of two clocks.
    assert "another clock" in " ".join(notes.Sentences())
    assert timeline.Place(_raw(0.5, [1.0]), notes.On("/d", "detection")) == []
    assert "left out 1 detection of another" in " ".join(notes.Sentences())


def test_a_sender_whose_clock_is_ahead_is_told_from_one_that_is_not():
    timeline, _ = _timeline(_raw(0.01, [0.1 * i for i in range(20)]))
    assert timeline.AheadWarning(_raw(0.05, [0.1, 0.2])) == ""
    assert "0.310 s" in timeline.AheadWarning(_raw(-0.3, [0.1, 0.2]))
    assert timeline.AheadWarning([]) == ""
