"""Where a shape touches what it stands on: small spheres at its corners.

Point contact gives one point per pair of geometries. A box on a box then
rocks and sinks, and a can sticks. Small spheres at the corners, or around
both rims, give the contact the extent that it really has. They are made from
the shape, so that a user's model gets them too.

The spheres are soft, so that the physics can take long steps: with ten times
the stiffness, steps would have to be less than half as long. A sphere sticks
out of the shape by as much as it sinks in, so that a thing on four of them is
as high as it should be.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import Box, Capsule, Convex, Cylinder, Mesh, Shape

from pbpf_drake.shapes.box_corners import box_corners

# The stiffness of a contact (in N/m per kg of the object): of a sphere, and of
# the shape itself, which is what the robot touches.
POINT_STIFFNESS = 3e3
SHAPE_STIFFNESS = 1e4
# How deep a thing that stands on four points sinks in (in meters).
REST_DEPTH = 9.81 / (4 * POINT_STIFFNESS)
# Radius of the spheres (in meters).
_RADIUS = REST_DEPTH
# How many points there are around each rim of a cylinder.
_RIM_POINTS = 8
# How many vertices of a convex hull are points, at most.
_HULL_POINTS = 16
# By how much a core is smaller than its shape, on every side (in meters).
INSET = 1e-3


@dataclass(frozen=True)
class ContactPoints:
    """Small spheres that touch things in the place of a shape.

    Attributes:
        p_GS: (n, 3) the spheres' centres in the shape's frame G (in meters).
        radius: of every sphere (in meters).
    """

    p_GS: np.ndarray
    radius: float


def MakeContactPoints(shape: Shape) -> ContactPoints:
    """Returns the spheres of a shape; none if it is round all over."""
    if isinstance(shape, Box):
        return ContactPoints(box_corners(shape.size() / 2), _RADIUS)
    if isinstance(shape, Cylinder):
        return ContactPoints(_rims(shape), _RADIUS)
    if isinstance(shape, Capsule):
        ends = np.array([[0, 0, -1], [0, 0, 1]]) * shape.length() / 2
        return ContactPoints(ends, shape.radius())
    if isinstance(shape, Convex | Mesh):
        return ContactPoints(_hull_vertices(shape), _RADIUS)
    return ContactPoints(np.empty((0, 3)), _RADIUS)


def MakeCore(shape: Shape) -> Shape | None:
    """Returns the shape made a little smaller, to touch between the spheres.

    Where the spheres carry the shape, its core touches nothing. The core stops
    what gets in between the spheres: where an edge lies across another edge, or
    a can lies on its side.

    Returns:
        The core; None for a shape that is its own core.
    """
    if isinstance(shape, Box) and min(shape.size()) > 4 * INSET:
        return Box(*(shape.size() - 2 * INSET))
    if isinstance(shape, Cylinder) and (
        min(shape.radius(), shape.length()) > 4 * INSET
    ):
        return Cylinder(
            radius=shape.radius() - INSET, length=shape.length() - 2 * INSET
        )
    return None


def _rims(cylinder: Cylinder) -> np.ndarray:
    """Returns evenly spaced points on both rims, (2 * _RIM_POINTS, 3)."""
    angles = 2 * np.pi * np.arange(_RIM_POINTS) / _RIM_POINTS
    z = cylinder.length() / 2
    rim = cylinder.radius() * np.column_stack([np.cos(angles), np.sin(angles)])
    return np.vstack(
        [np.column_stack([rim, np.full(_RIM_POINTS, end)]) for end in (-z, z)]
    )


def _hull_vertices(shape: Convex | Mesh) -> np.ndarray:
    """Returns some of the hull's vertices, far from each other, (n, 3).

    The first is the one farthest from the middle; each of the others is the one
    farthest from those chosen before it.
    """
    hull = shape.GetConvexHull()
    vertices = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
    centre = vertices.mean(axis=0)
    chosen = [int(np.argmax(np.linalg.norm(vertices - centre, axis=1)))]
    distance = np.linalg.norm(vertices - vertices[chosen[0]], axis=1)
    while len(chosen) < min(_HULL_POINTS, len(vertices)):
        chosen.append(int(np.argmax(distance)))
        new = np.linalg.norm(vertices - vertices[chosen[-1]], axis=1)
        distance = np.minimum(distance, new)
    return vertices[chosen]
