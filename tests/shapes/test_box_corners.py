import numpy as np
import pytest

from pbpf_drake.shapes.box_corners import box_corners, box_edges

HALF = np.array([0.1, 0.2, 0.3])


def test_there_is_a_corner_on_every_side_of_the_centre():
    corners = box_corners(HALF)
    assert corners.shape == (8, 3)
    np.testing.assert_array_equal(np.abs(corners), np.tile(HALF, (8, 1)))
    assert len({tuple(c) for c in corners}) == 8


@pytest.mark.parametrize("shape", [(1, 3), (4, 3), (2, 5, 3)])
def test_many_boxes_have_the_corners_that_each_has_alone(shape):
    half = np.random.default_rng(0).uniform(0.1, 1.0, shape)
    corners = box_corners(half)
    assert corners.shape == (*shape[:-1], 8, 3)
    for index in np.ndindex(shape[:-1]):
        np.testing.assert_array_equal(corners[index], box_corners(half[index]))


def test_each_edge_goes_along_one_axis_from_its_negative_side():
    start, end = np.moveaxis(box_edges(HALF), 1, 0)
    along = end != start
    np.testing.assert_array_equal(along.sum(axis=1), 1)
    np.testing.assert_array_equal(along.sum(axis=0), 4)
    np.testing.assert_array_equal(end, np.where(along, -start, start))
    assert np.all((start < 0)[along])


def test_no_edge_is_there_twice():
    edges = box_edges(HALF)
    assert edges.shape == (12, 2, 3)
    assert len({tuple(edge.ravel()) for edge in edges}) == 12
