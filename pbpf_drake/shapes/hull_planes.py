"""The planes that bound a convex hull."""

import numpy as np
from pydrake.geometry import PolygonSurfaceMesh


def MakeHullPlanes(hull: PolygonSurfaceMesh) -> tuple[np.ndarray, np.ndarray]:
    """Returns the planes that the F faces of a hull are in.

    A point p of the hull's frame is inside where normal · p ≤ offset holds
    for all of them.

    Returns:
        The unit normals (F, 3), outwards, and the offsets (F,): how far the
        planes are from the origin (in meters).
    """
    faces = range(hull.num_faces())
    normals = np.array([hull.face_normal(f) for f in faces])
    corners = np.array([hull.vertex(hull.element(f).vertex(0)) for f in faces])
    return normals, np.einsum("fi,fi->f", normals, corners)
