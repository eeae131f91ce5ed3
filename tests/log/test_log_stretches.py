"""Of a log whose stamps jump back, one part is used."""

from log_fixtures import has_warning
from mcap_fixtures import DETECTIONS, JOINT_STATES, SECOND, T0, TRUTH
import pytest

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.log_samples import RawStamped
from pbpf_drake.log.log_stretches import find_stretch


def _find(*stamps):
    """Returns which of the messages at these stamps are kept, and notes.

    One is logged every tenth of a second.
    """
    notes = LogNotes()
    messages = [
        RawStamped(T0 + i * SECOND // 10, round(s * SECOND), i)
        for i, s in enumerate(stamps)
    ]
    stretch = find_stretch(messages, notes)
    kept = stretch.Of(messages, notes.On("/a", "message"))
    return [m.value for m in kept], notes.Sentences()


def _run(start, count):
    return [start + 0.2 * i for i in range(count)]


@pytest.mark.parametrize(
    ("counts", "kept"),
    [
        ((10, 10), range(10)),
        ((10, 12), range(10, 22)),
        ((10, 15, 8), range(10, 25)),
        ((9, 9, 9, 10), range(27, 37)),
    ],
)
def test_the_longest_stretch_is_used_and_of_equal_ones_the_first(counts, kept):
    found, notes = _find(*(t for n in counts for t in _run(50.0, 20)[-n:]))
    assert found == list(kept)
    assert f"of {len(counts)} stretches only" in notes[0]
    assert "looped" in notes[0] and "reset" in notes[0]
    left = sum(counts) - len(kept)
    assert f"/a: left out {left} messages of another stretch" in notes[1]


@pytest.mark.parametrize("wrong", [0.5, 20.0, 90.0])
def test_single_stamps_that_are_wrong_are_no_jump(wrong):
    stamps = _run(50.0, 20)
    stamps[8] = wrong
    assert _find(*stamps) == (list(range(20)), ())


def test_small_disorder_is_no_jump():
    stamps = [50.0 + 0.1 * i - 0.9 * (i % 2) for i in range(20)]
    assert _find(*stamps) == (list(range(20)), ())


def test_messages_without_stamps_are_no_jump():
    assert _find(*[0.0] * 20) == (list(range(20)), ())


def test_a_looped_bag_is_read_once_with_all_its_topics(faulty):
    for loop in range(2):
        for i in range(30):
            time, delay = 0.1 * i, 3.1 * loop
            faulty.joints(time, positions=(loop, i), delay=delay)
            faulty.truth(time, delay=delay)
            faulty.detection(time, delay=delay)
    log = faulty.read()
    assert log.joints.positions[:, 0].tolist() == [0.0] * 30
    assert len(log.joints.times) == len(log.detections) == 30
    assert [d.received for d in log.detections] == [
        d.time for d in log.detections
    ]
    for topic in (JOINT_STATES, DETECTIONS, TRUTH):
        assert has_warning(log, topic, "left out 30", "another stretch")
    assert not has_warning(log, "put in order")
