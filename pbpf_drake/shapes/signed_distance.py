"""How far points are from Drake's shapes, and in which direction.

Contacts of small spheres are found with it, for all particles at once. A mesh
counts as its convex hull, as in Drake's point contact.
"""

from collections.abc import Callable
import functools

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    Shape,
    Sphere,
)

from pbpf_drake.shapes.hull_planes import MakeHullPlanes

# From points (..., 3) in the shape's frame (in meters) to their distances (...)
# from the surface (in meters), negative inside, and to unit vectors (..., 3)
# in the direction in which the distances grow most.
SignedDistance = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]

_TINY = 1e-300


def MakeSignedDistance(shape: Shape) -> SignedDistance:
    """Returns the distance function of a shape.

    It is exact for all shapes but two. For an ellipsoid it holds to first order
    near the surface. For a hull it is too small where the nearest point of the
    hull is on an edge or at a corner.

    Raises:
        ValueError: the shape has no volume that Drake could collide with.
        RuntimeError: the file of a mesh can't be read.
    """
    match shape:
        case Box():
            half = 0.5 * np.asarray(shape.size())
            return lambda p: _box(p, half)
        case Sphere():
            return lambda p: _ball(p, shape.radius())
        case Ellipsoid():
            axes = np.array([shape.a(), shape.b(), shape.c()])
            return lambda p: _ellipsoid(p, axes)
        case Cylinder():
            size = np.array([shape.radius(), 0.5 * shape.length()])
            return lambda p: _cylinder(p, size)
        case Capsule():
            radius, half_length = shape.radius(), 0.5 * shape.length()
            return lambda p: _capsule(p, radius, half_length)
        case HalfSpace():
            return lambda p: _polytope(p, np.eye(3)[2:], np.zeros(1))
        case Convex() | Mesh():
            normals, offsets = MakeHullPlanes(shape.GetConvexHull())
            return lambda p: _polytope(p, normals, offsets)
    raise ValueError(
        f"nothing has a distance from {shape}; expected a Box, Sphere, "
        "Ellipsoid, Cylinder, Capsule, HalfSpace, Convex or Mesh"
    )


def _unit(v: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.maximum(length, _TINY)


def _box(p: np.ndarray, half: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    beyond = np.abs(p) - half
    deepest = functools.reduce(np.maximum, np.moveaxis(beyond, -1, 0))
    is_inside = deepest <= 0
    way = np.where(
        is_inside[..., None],
        beyond == deepest[..., None],  # The nearest face.
        np.maximum(beyond, 0.0),
    )
    length = np.sqrt(np.einsum("...i,...i", way, way))
    distance = np.where(is_inside, deepest, length)
    return distance, np.copysign(way, p) / length[..., None]


def _ball(p: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    return np.linalg.norm(p, axis=-1) - radius, _unit(p)


def _ellipsoid(
    p: np.ndarray, axes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    scaled = np.linalg.norm(p / axes, axis=-1)
    gradient = p / axes**2 / np.maximum(scaled, _TINY)[..., None]
    slope = np.maximum(np.linalg.norm(gradient, axis=-1), _TINY)
    return (scaled - 1) / slope, _unit(gradient)


def _cylinder(p: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Takes it for a box in the plane through its axis and the point."""
    radial = np.linalg.norm(p[..., :2], axis=-1)
    distance, normal = _box(np.stack([radial, p[..., 2]], axis=-1), size)
    outwards = p[..., :2] / np.maximum(radial, _TINY)[..., None]
    return distance, np.concatenate(
        [outwards * normal[..., :1], normal[..., 1:]], axis=-1
    )


def _capsule(
    p: np.ndarray, radius: float, half_length: float
) -> tuple[np.ndarray, np.ndarray]:
    offset = p.copy()
    offset[..., 2] -= np.clip(p[..., 2], -half_length, half_length)
    return _ball(offset, radius)


def _polytope(
    p: np.ndarray, normals: np.ndarray, offsets: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    beyond = p @ normals.T - offsets
    nearest = np.argmax(beyond, axis=-1)
    return np.max(beyond, axis=-1), normals[nearest]
