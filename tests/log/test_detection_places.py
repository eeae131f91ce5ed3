"""Detections that can't be where they are said to be are told."""

from log_fixtures import has_warning
import numpy as np
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.log.detection_places import (
    distances_to_boxes,
    in_or_near_image,
    place_warnings,
)
from pbpf_drake.model_facts import ModelFacts

# A box around what is one meter in front of the camera.
_BOXES = np.array([[[-0.1, -0.1, 0.9], [0.1, 0.1, 1.1]]])


def _warnings(*points):
    return place_warnings(
        np.array(points, dtype=float),
        camera=CameraConfig(),
        X_WC=RigidTransform(),
        boxes=_BOXES,
    )


def test_what_is_near_something_and_in_the_image_is_no_problem():
    assert _warnings([0, 0, 1], [0.4, 0.2, 1.2], [0.05, 0, 0.5]) == []


@pytest.mark.parametrize(
    ("point", "where", "remedy"),
    [
        ((0, 0, 0), "at the camera", "check the unit, the field"),
        ((0, 0, 0.1), "at the camera", "times 10 they would"),
        ((0, 0, -1), "behind the camera", "its frame, and the scene's camera"),
        ((1, 0, 0.5), "outside the camera's image", "frame"),
        ((1, 0, 100), "more than 1 m from everything", "times 0.01 they"),
        ((1, 0, 1000), "more than 1 m from everything", "times 0.001 they"),
        ((0, 0, 5), "more than 1 m from everything", "check the unit, the"),
    ],
)
def test_misplaced_detections_are_told_with_a_remedy(point, where, remedy):
    (said,) = _warnings(point, point, (0, 0, 1))
    assert said.startswith(f"2 of 3 are {where}")
    assert remedy in said
    assert str([float(x) for x in point]) in said


def test_a_few_outliers_are_no_misplaced_detections():
    assert _warnings(*[(0, 0, 1)] * 10, (0, 0, -1)) == []


def test_an_object_in_part_in_the_image_may_have_its_centre_outside():
    camera = CameraConfig(width=100, height=100, fx=100, fy=100, cx=50, cy=50)
    points = np.array([[0.6, 0, 1], [0.8, 0, 1], [0, -0.6, 1], [0, -0.8, 1]])
    found = in_or_near_image(points, camera)
    assert found.tolist() == [True, False, True, False]


def test_distances_are_to_the_nearest_box_and_zero_inside():
    boxes = np.array([[[0, 0, 0], [1, 1, 1]], [[5, 0, 0], [6, 1, 1]]])
    points = np.array([[0.5, 0.5, 0.5], [4.0, 0.5, 0.5], [0.5, 4.0, 5.0]])
    assert distances_to_boxes(points, boxes).tolist() == [0.0, 1.0, 5.0]
    assert distances_to_boxes(points, boxes[:0]).tolist() == [0.0] * 3


def test_a_log_in_centimetres_says_so(faulty):
    faulty.joints(0.0)
    for i in range(5):
        faulty.detection(0.1 * i, p=(0, 0, 100))
    log = faulty.read(facts=ModelFacts(boxes=_BOXES))
    assert has_warning(log, "'box'", "5 of 5", "times 0.01 they would be near")
