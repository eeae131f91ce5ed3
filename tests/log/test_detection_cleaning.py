"""Detections that can't be used are left out and counted."""

import math

from log_fixtures import has_warning
from mcap_fixtures import DETECTIONS
import numpy as np
import pytest

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.detection_cleaning import make_detection_records
from pbpf_drake.log.log_samples import PoseSample, Stamped


def test_a_log_without_detections_is_read_and_says_so(faulty):
    faulty.joints(0.0)
    log = faulty.read()
    assert log.detections == ()
    assert has_warning(
        log, "no detections of ['box']", DETECTIONS, "nominal poses"
    )


@pytest.mark.parametrize(
    "fault, reason",
    [
        ({"q": (0, 0, 0, 0)}, "quaternion is zero"),
        ({"q": (1e-7, 0, 0, 0)}, "quaternion is zero"),
        ({"q": (math.nan, 0, 0, 1)}, "quaternion is not finite"),
        ({"q": (math.inf, 0, 0, 1)}, "quaternion is not finite"),
        ({"p": (math.nan, 0, 0)}, "position is not finite"),
        ({"p": (0, 0, math.inf)}, "position is not finite"),
        ({"name": "mug"}, "unknown class 'mug'"),
    ],
)
def test_a_bad_detection_is_left_out(faulty, fault, reason):
    faulty.joints(0.0)
    faulty.detection(0.1)
    faulty.detection(0.2, **fault)
    faulty.detection(0.3, **fault)
    log = faulty.read()
    assert [d.time for d in log.detections] == [0.1]
    assert has_warning(log, DETECTIONS, "left out 2 detections", reason)
    assert len(log.warnings) == 1


def _records(name, *class_ids):
    """Returns the names and times of the records, and the notes."""
    notes = LogNotes()
    messages = [
        Stamped(
            i * 10**9,
            i * 10**9,
            PoseSample("camera", class_id, np.array([1, 0, 0, 0]), np.ones(3)),
        )
        for i, class_id in enumerate(class_ids)
    ]
    records = make_detection_records(
        messages,
        name=name,
        names_by_class={"008": "box", "can": "can"},
        start=10**9,
        notes=notes.On("/seen", "detection"),
    )
    return [(r.name, r.time) for r in records], notes.Sentences()


def test_detections_are_told_apart_by_their_classes():
    records, said = _records(None, "008", "can", "mug", "008")
    assert records == [("box", -1.0), ("box", 2.0), ("can", 0.0)]
    assert said == ("/seen: left out 1 detection of the unknown class 'mug'",)


def test_what_is_known_to_be_one_object_needs_no_class():
    records, said = _records("can", "", "mug")
    assert records == [("can", -1.0), ("can", 0.0)]
    assert said == ()
