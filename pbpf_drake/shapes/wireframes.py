"""Edges of shapes, to draw them as wireframes.

Edges are straight segments in the frame G of the shape, (E, 2, 3) in meters. A
round shape has none: it gets the circles in its planes of symmetry.
"""

import numpy as np
from pydrake.geometry import (
    Box,
    CalcObb,
    Capsule,
    Cylinder,
    Ellipsoid,
    Shape,
    Sphere,
)

from pbpf_drake.shapes.box_corners import box_edges

# How many segments a full circle has; a multiple of 4.
_NUM_SEGMENTS = 24


def ShapeEdges(shape: Shape) -> np.ndarray:
    """Returns the edges of a shape; a mesh has those of the box around it.

    Raises:
        ValueError: the shape has no size.
    """
    match shape:
        case Box():
            return box_edges(0.5 * np.asarray(shape.size()))
        case Sphere():
            return ellipsoid_edges(np.full(3, shape.radius()))
        case Ellipsoid():
            return ellipsoid_edges(np.array([shape.a(), shape.b(), shape.c()]))
        case Cylinder():
            return cylinder_edges(shape.radius(), shape.length())
        case Capsule():
            return capsule_edges(shape.radius(), shape.length())
    box = CalcObb(shape)
    if box is None:
        raise ValueError(f"{shape} has no edges; expected a shape of some size")
    R, p = box.pose().rotation().matrix(), box.pose().translation()
    return box_edges(np.asarray(box.half_width())) @ R.T + p


def cylinder_edges(radius: float, length: float) -> np.ndarray:
    """Returns both ends of a cylinder along z, and four lines between."""
    circle = _arc(1.0) * radius
    up = np.array([0.0, 0.0, 0.5 * length])
    return np.concatenate([circle + up, circle - up, _sides(radius, length)])


def capsule_edges(radius: float, length: float) -> np.ndarray:
    """Returns a cylinder's edges and, over each end, two half circles."""
    up = np.array([0.0, 0.0, 0.5 * length])
    # One half circle goes from x over z, the other from y over z.
    half = _arc(0.5) * radius
    over = np.concatenate([half[..., [0, 2, 1]], half[..., [2, 0, 1]]])
    ends = [over + up, over * [1.0, 1.0, -1.0] - up]
    return np.concatenate([cylinder_edges(radius, length), *ends])


def ellipsoid_edges(radii: np.ndarray) -> np.ndarray:
    """Returns the three ellipses in the planes of the axes; radii (3,)."""
    circle = _arc(1.0)
    circles = [np.roll(circle, axis, axis=-1) for axis in range(3)]
    return np.concatenate(circles) * radii


def _arc(share: float) -> np.ndarray:
    """Returns a part of the unit circle around z, from x towards y.

    Args:
        share: how much of the circle, up to 1.
    """
    count = round(share * _NUM_SEGMENTS)
    angles = 2 * np.pi * np.arange(count + 1) / _NUM_SEGMENTS
    points = np.stack(
        [np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1
    )
    return np.stack([points[:-1], points[1:]], axis=1)


def _sides(radius: float, length: float) -> np.ndarray:
    """Returns four lines along the side of a cylinder."""
    around = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]]) * radius
    sides = np.empty((4, 2, 3))
    sides[..., :2] = around[:, None]
    sides[..., 2] = [-0.5 * length, 0.5 * length]
    return sides
