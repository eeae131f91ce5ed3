"""Detections that can't be used are left out and counted."""

import math

from log_fixtures import has_warning
from mcap_fixtures import DETECTIONS, pose
import numpy as np
import pytest

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.detection_cleaning import detections_by_object
from pbpf_drake.log.log_samples import PoseSample, RawStamped


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
        ({"p": (0, -1e300, 2)}, "that is more than 1e+06 m away"),
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
    # That of a class that isn't tracked is no loss.
    lost = fault.get("name") != "mug"
    assert len(log.warnings) == 1 + lost
    assert lost == has_warning(log, "only 1 of 3 detections of 'box' can be")


def _by_object(name, *class_ids):
    """Returns the objects with the times of their detections, and the notes."""
    notes = LogNotes()
    messages = [
        RawStamped(
            i * 10**9,
            i * 10**9,
            PoseSample("camera", class_id, np.array([1, 0, 0, 0]), np.ones(3)),
        )
        for i, class_id in enumerate(class_ids)
    ]
    found = detections_by_object(
        messages,
        name=name,
        names_by_class={"008": "box", "can": "can"},
        notes=notes.On("/seen", "detection"),
    )
    times = {n: [m.stamp // 10**9 for m in ms] for n, ms in found.items()}
    return times, notes.Sentences()


def test_detections_are_told_apart_by_their_classes():
    times, said = _by_object(None, "008", "can", "mug", "008")
    assert times == {"box": [0, 3], "can": [1]}
    assert said == ("/seen: left out 1 detection of the unknown class 'mug'",)


def test_what_is_known_to_be_one_object_needs_no_class():
    times, said = _by_object("can", "", "mug")
    assert times == {"can": [0, 1]}
    assert said == ()


def test_times_are_relative_to_the_start_of_the_log(faulty):
    faulty.detection(0.1, delay=0.05)
    faulty.joints(0.2)
    faulty.detection(0.5, delay=0.05)
    log = faulty.read()
    assert [d.time for d in log.detections] == [-0.1, 0.3]
    assert [d.received for d in log.detections] == [-0.05, 0.35]


def test_the_box_is_used_where_the_result_has_no_pose_and_that_is_said(faulty):
    faulty.joints(0.0)
    box = pose((1, 0, 0, 0), (0, 0, 2))
    faulty.detection(0.1, q=(0, 0, 0, 0), p=(0, 0, 0), box=box)
    faulty.detection(0.2, q=(1, 0, 0, 0), p=(0, 0, 0), box=box)
    faulty.detection(0.3, q=(1, 0, 0, 0), p=(0, 0, 3), box=box)
    log = faulty.read()
    found = [d.X_CO.translation().tolist() for d in log.detections]
    assert found == [[0, 0, 2], [0, 0, 2], [0, 0, 3]]
    assert has_warning(log, DETECTIONS, "from bbox.center the pose of 2 detect")
