"""Of several detections of a class in one image, one is the tracked object."""

from log_fixtures import has_warning
from mcap_fixtures import DETECTION_ARRAY, DETECTIONS, detection_message
import numpy as np
import pytest

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.instance_choice import one_instance
from pbpf_drake.log.log_samples import PoseSample, Stamped
from pbpf_drake.model_facts import ModelFacts

_Q = np.array([1.0, 0, 0, 0])


def _choose(*detections, expected=None):
    """Returns which are kept of (time, x, score), and the notes."""
    notes = LogNotes()
    messages = [
        Stamped(t, i, PoseSample("", "box", _Q, np.array([x, 0, 1.0]), score))
        for i, (t, x, score) in enumerate(detections)
    ]
    place = None if expected is None else np.array([expected, 0, 1.0])
    kept = one_instance(messages, place, notes.On("/seen", "detection"))
    found = [m.received for m in kept]
    return found, notes.Sentences()


@pytest.mark.parametrize("first", [True, False])
def test_the_higher_score_wins_wherever_it_is(first):
    pair = [(5, 0.0, 0.9), (5, 0.3, 0.2)]
    kept, notes = _choose(*(pair if first else pair[::-1]), expected=0.3)
    assert kept == [0 if first else 1]
    assert notes == (
        "/seen: left out 1 detection for another instance of the class in the "
        "same image with a higher score",
    )


@pytest.mark.parametrize("score", [0.9, 0.0, -2.0, float("nan")])
def test_of_equal_scores_the_one_that_is_nearest_to_the_last_wins(score):
    pairs = [
        (t, x, score) for t in range(4) for x in ((0.3, 0.0), (0.0, 0.3))[t % 2]
    ]
    kept, notes = _choose(*pairs, expected=0.05)
    assert [pairs[i][1] for i in kept] == [0.0] * 4
    assert "nearer to where it was before" in notes[0]


def test_scores_that_are_almost_equal_do_not_make_it_jump():
    pairs = [
        (t, x, 0.9 + 0.03 * ((t % 2) == (x > 0)))
        for t in range(6)
        for x in (0.0, 0.3)
    ]
    kept, _ = _choose(*pairs)
    assert len({pairs[i][1] for i in kept}) == 1


def test_without_a_place_to_expect_it_the_first_of_the_best_wins():
    assert _choose((1, 0.0, 0.5), (1, 0.3, 0.7), (1, 0.6, 0.7))[0] == [1]


def test_the_same_detection_twice_is_no_other_instance():
    kept, notes = _choose((1, 0.0, 0.5), (1, 0.0, 0.5), (2, 0.0, 0.5))
    assert kept == [0, 1, 2]
    assert notes == ()


def test_in_a_log_the_scene_s_pose_tells_which_of_two_is_tracked(faulty):
    faulty.joints(0.0)
    for i in range(5):
        pair = [
            detection_message("box", _Q, (x, 0, 2), 0.8) for x in (0.25, 0.0)
        ]
        message = {"detections": pair}
        faulty.write(DETECTIONS, DETECTION_ARRAY, message, 0.1 * i)
    facts = ModelFacts(nominal={"box": np.array([0.02, 0.0, 2.0])})
    log = faulty.read(facts=facts)
    assert [d.X_CO.translation()[0] for d in log.detections] == [0.0] * 5
    assert has_warning(
        log, "left out 5 detections for another instance of the class"
    )
