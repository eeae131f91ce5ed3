"""Of all input it is known what was used, and why the rest was not."""

import math

from log_fixtures import has_warning
from mcap_fixtures import DETECTIONS, JOINT_STATES, TRUTH
import pytest

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.input_usage import make_usage, usage_lines, usage_warning


def _usage(read, left_out, noun="detection", owner="box"):
    notes = LogNotes().On("/seen", noun).Of(owner)
    for _ in range(left_out):
        notes.CountLeftOut("whose quaternion is zero")
    return make_usage(notes, read=read)


def test_what_is_not_left_out_is_used():
    usage = _usage(10, 3)
    assert (usage.source, usage.name, usage.noun) == (
        "/seen", "box", "detection",
    )  # fmt: skip
    assert (usage.read, usage.used, usage.num_left_out) == (10, 7, 3)
    assert usage_lines([usage]) == [
        "/seen: 10 detections of 'box' read, 7 used; 3 left out: whose "
        "quaternion is zero"
    ]


@pytest.mark.parametrize(
    ("left_out", "noun", "owner", "warns"),
    [
        (0, "detection", "box", False),
        (2, "detection", "box", False),
        (3, "detection", "box", True),
        (20, "detection", "box", True),
        (3, "message", "box", False),
        (3, "detection", "", False),
    ],
)
def test_more_than_a_tenth_of_an_object_s_detections_is_worth_a_warning(
    left_out, noun, owner, warns
):
    said = usage_warning(_usage(20, left_out, noun, owner))
    assert bool(said) == warns
    if warns:
        assert f"only {20 - left_out} of 20 detections of 'box'" in said


def test_a_log_counts_every_topic_and_object(faulty):
    for i in range(6):
        faulty.joints(0.1 * i, positions=(0.0, math.nan if i == 3 else 0.0))
        faulty.truth(0.1 * i)
    faulty.joints(0.6, names=("x",), positions=(0.0,))
    for i in range(4):
        faulty.detection(0.1 * i)
        faulty.detection(0.1 * i + 0.01, name="mug")
    faulty.detection(0.3)
    faulty.detection(0.4, q=(0, 0, 0, 0))
    faulty.raw(DETECTIONS, b"\0\1\0\0\xff", 0.5)
    faulty.raw(JOINT_STATES, b"", 0.5)
    log = faulty.read()
    rows = {(u.source, u.name, u.noun): u for u in log.usage}
    counts = {key: (u.read, u.used) for key, u in rows.items()}
    assert counts == {
        (JOINT_STATES, "", "message"): (8, 5),
        (DETECTIONS, "box", "detection"): (6, 4),
        (DETECTIONS, "", "detection"): (4, 0),
        (DETECTIONS, "", "message"): (11, 10),
        (TRUTH, "box", "message"): (6, 6),
    }
    assert len(log.joints.times) == 5 and len(log.detections) == 4
    assert rows[DETECTIONS, "box", "detection"].left_out == {
        "with the stamp of an earlier one": 1,
        "whose quaternion is zero": 1,
    }
    assert rows[DETECTIONS, "", "detection"].left_out == {
        "of the unknown class 'mug'": 4
    }
    assert has_warning(log, "only 4 of 6 detections of 'box' can be used")
