import numpy as np
from pydrake.geometry import Convex
from scipy.spatial import ConvexHull

from pbpf_drake.shapes.hull_planes import MakeHullPlanes

CORNERS = np.random.default_rng(5).uniform(-0.3, 0.3, (12, 3))


def test_the_planes_are_those_that_qhull_finds():
    hull = Convex(CORNERS.T, "corners").GetConvexHull()
    normals, offsets = MakeHullPlanes(hull)
    found = np.column_stack([normals, -offsets])
    expected = ConvexHull(CORNERS).equations
    gaps = np.abs(found[:, None] - expected).max(axis=-1)
    assert gaps.min(axis=0).max() < 1e-12
    assert gaps.min(axis=1).max() < 1e-12


def test_corners_are_inside_of_all_planes_also_where_the_origin_is_not():
    corners = CORNERS + [1.0, 2.0, -0.5]
    hull = Convex(corners.T, "corners").GetConvexHull()
    normals, offsets = MakeHullPlanes(hull)
    heights = corners @ normals.T - offsets
    assert heights.max() < 1e-12
    # Each plane touches a corner, and the origin is outside of some.
    np.testing.assert_allclose(heights.max(axis=0), 0.0, atol=1e-12)
    assert np.any(offsets < 0)
