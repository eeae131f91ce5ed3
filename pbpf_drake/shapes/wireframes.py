"""Edges of shapes, to draw them as wireframes.

Edges are straight segments in the frame G of the shape, (E, 2, 3) in meters.
Round shapes have the circles in their planes of symmetry.
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

# Segments of a full circle; a multiple of 4.
_NUM_SEGMENTS = 24


def shape_edges(shape: Shape) -> np.ndarray:
    """Returns the edges of a shape; a mesh has those of the box around it.

    Raises:
        ValueError: the shape has no size.
    """
    if isinstance(shape, Cylinder):
        return cylinder_edges(shape.radius(), shape.length())
    if isinstance(shape, Capsule):
        return capsule_edges(shape.radius(), shape.length())
    if isinstance(shape, Sphere):
        return ellipsoid_edges(np.full(3, shape.radius()))
    if isinstance(shape, Ellipsoid):
        return ellipsoid_edges(np.array([shape.a(), shape.b(), shape.c()]))
    if isinstance(shape, Box):
        return box_edges(0.5 * np.asarray(shape.size()))
    box = CalcObb(shape)
    if box is None:
        raise ValueError(f"{shape} has no edges; expected a shape of some size")
    R, p = box.pose().rotation().matrix(), box.pose().translation()
    return box_edges(np.asarray(box.half_width())) @ R.T + p


def box_edges(half_size: np.ndarray) -> np.ndarray:
    """Returns the 12 edges of a box, whose half size is (3,)."""
    corners = (np.arange(8)[:, None] >> np.arange(3) & 1) * 2 - 1
    edges = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]
    return (corners * half_size)[np.array(edges)]


def cylinder_edges(radius: float, length: float) -> np.ndarray:
    """Returns both circles and four sides of a cylinder along z."""
    circle = _arc(1.0) * radius
    up = np.array([0.0, 0.0, 0.5 * length])
    return np.concatenate([circle + up, circle - up, _sides(radius, length)])


def capsule_edges(radius: float, length: float) -> np.ndarray:
    """Returns a cylinder's edges, and two half circles over each end."""
    up = np.array([0.0, 0.0, 0.5 * length])
    # From x over z, and from y over z.
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
    """Returns a share of the unit circle around z, from x towards y."""
    count = round(share * _NUM_SEGMENTS)
    angles = 2 * np.pi * np.arange(count + 1) / _NUM_SEGMENTS
    points = np.stack(
        [np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1
    )
    return np.stack([points[:-1], points[1:]], axis=1)


def _sides(radius: float, length: float) -> np.ndarray:
    around = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]]) * radius
    sides = np.empty((4, 2, 3))
    sides[..., :2] = around[:, None]
    sides[..., 2] = [-0.5 * length, 0.5 * length]
    return sides
