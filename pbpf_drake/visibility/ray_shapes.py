"""Rays against Drake's shapes, exact and vectorised.

A ray is the half line o + t d, t >= 0, in the shape's own frame G. d has any
length: with d = target - o, t is 0 at the origin and 1 at the target. (Where
d is 0, t is 0 inside a shape and more than 1 outside.) All shapes here are
convex (a mesh counts as its convex hull, as in Drake's point contact), so a
ray is inside a shape for one interval of t. Rays that touch a surface without
entering the shape may count as hits or as misses.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    PolygonSurfaceMesh,
    Shape,
    Sphere,
)

from pbpf_drake.shapes.hull_planes import MakeHullPlanes

# Divisions are by this instead of zero: quotients get huge, with the right
# sign, and do not overflow.
_TINY = 1e-300

Interval = tuple[np.ndarray, np.ndarray]


class RayShape(Protocol):
    """A solid that rays can enter.

    Attributes:
        bounding_radius: radius (in meters) of a sphere around the origin of G
            that contains the shape; inf if there is none.
        bounds: the lowest and the highest coordinates in G (in meters) of
            anything in the shape, (3,) each; inf where there is no limit.
    """

    @property
    def bounding_radius(self) -> float: ...

    @property
    def bounds(self) -> Interval: ...

    def intersect(self, o: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Returns where rays first touch the solid.

        Args:
            o: origins of the rays in G (in meters), (..., 3).
            d: directions of the rays in G (in meters), (..., 3); o and d
                broadcast against each other.

        Returns:
            The parameter t of the entry, (...): 0 where the origin is
            inside, inf where the ray misses.
        """
        ...


@dataclass(frozen=True, eq=False)
class RayBox:
    """A box with its centre in G's origin."""

    # Half of the edges' lengths (in meters), (3,).
    half_size: np.ndarray

    @property
    def bounding_radius(self) -> float:
        """See RayShape."""
        return float(np.linalg.norm(self.half_size))

    @property
    def bounds(self) -> Interval:
        """See RayShape."""
        return -self.half_size, self.half_size

    def intersect(self, o: np.ndarray, d: np.ndarray) -> np.ndarray:
        """See RayShape."""
        t_in, t_out = _slab_interval(o, d, self.half_size)
        return _entry(
            np.maximum(np.maximum(t_in[..., 0], t_in[..., 1]), t_in[..., 2]),
            np.minimum(np.minimum(t_out[..., 0], t_out[..., 1]), t_out[..., 2]),
        )


@dataclass(frozen=True, eq=False)
class RayEllipsoid:
    """An ellipsoid, or a sphere, with its centre in G's origin."""

    # The half axes (in meters), (3,).
    radii: np.ndarray

    @property
    def bounding_radius(self) -> float:
        """See RayShape."""
        return float(np.max(self.radii))

    @property
    def bounds(self) -> Interval:
        """See RayShape."""
        return -self.radii, self.radii

    def intersect(self, o: np.ndarray, d: np.ndarray) -> np.ndarray:
        """See RayShape."""
        return _entry(*_ball_interval(o / self.radii, d / self.radii))


@dataclass(frozen=True, eq=False)
class RayCylinder:
    """A cylinder along G's z axis with its centre in G's origin."""

    radius: float
    # Half of the length (in meters).
    half_length: float

    @property
    def bounding_radius(self) -> float:
        """See RayShape."""
        return float(np.hypot(self.radius, self.half_length))

    @property
    def bounds(self) -> Interval:
        """See RayShape."""
        half = np.array([self.radius, self.radius, self.half_length])
        return -half, half

    def intersect(self, o: np.ndarray, d: np.ndarray) -> np.ndarray:
        """See RayShape."""
        round_in, round_out = _ball_interval(
            o[..., :2] / self.radius, d[..., :2] / self.radius
        )
        flat_in, flat_out = _slab_interval(
            o[..., 2], d[..., 2], self.half_length
        )
        return _entry(
            np.maximum(round_in, flat_in), np.minimum(round_out, flat_out)
        )


@dataclass(frozen=True, eq=False)
class RayCapsule:
    """A cylinder along G's z axis with half a sphere at each end."""

    radius: float
    # Half of the cylinder's length (in meters).
    half_length: float

    @property
    def bounding_radius(self) -> float:
        """See RayShape."""
        return self.radius + self.half_length

    @property
    def bounds(self) -> Interval:
        """See RayShape."""
        half = np.array([self.radius, self.radius, self.bounding_radius])
        return -half, half

    def intersect(self, o: np.ndarray, d: np.ndarray) -> np.ndarray:
        """See RayShape."""
        ball = RayEllipsoid(np.full(3, self.radius))
        end = np.array([0.0, 0.0, self.half_length])
        t = RayCylinder(self.radius, self.half_length).intersect(o, d)
        t = np.minimum(t, ball.intersect(o - end, d))
        return np.minimum(t, ball.intersect(o + end, d))


@dataclass(frozen=True, eq=False)
class RayPolytope:
    """The points p of G with normals p <= offsets: a convex polytope.

    Also what is unbounded, a half space, fits.
    """

    # Unit normals that point outwards, (F, 3).
    normals: np.ndarray
    # Distances of the faces' planes from G's origin (in meters), (F,).
    offsets: np.ndarray
    bounding_radius: float
    # See RayShape.
    bounds: Interval

    def intersect(self, o: np.ndarray, d: np.ndarray) -> np.ndarray:
        """See RayShape."""
        depth = self.offsets - _dot(o[..., None, :], self.normals)
        rate = _dot(d[..., None, :], self.normals)
        enters = rate < 0
        t = depth / np.where(rate == 0, _TINY, rate)
        return _entry(
            np.max(np.where(enters, t, -np.inf), axis=-1),
            np.min(np.where(enters, np.inf, t), axis=-1),
        )


def MakeRayShape(shape: Shape) -> RayShape:
    """Returns what rays meet where Drake has ``shape``.

    Raises:
        ValueError: the shape has no volume that Drake could collide with.
        RuntimeError: the file of a mesh can't be read.
    """
    match shape:
        case Box():
            return RayBox(0.5 * np.asarray(shape.size()))
        case Sphere():
            return RayEllipsoid(np.full(3, shape.radius()))
        case Ellipsoid():
            return RayEllipsoid(np.array([shape.a(), shape.b(), shape.c()]))
        case Cylinder():
            return RayCylinder(shape.radius(), 0.5 * shape.length())
        case Capsule():
            return RayCapsule(shape.radius(), 0.5 * shape.length())
        case HalfSpace():
            return _half_space()
        case Convex() | Mesh():
            return _make_polytope(shape.GetConvexHull())
    raise ValueError(
        f"no rays can be cast at {shape}; expected a Box, Sphere, Ellipsoid, "
        "Cylinder, Capsule, HalfSpace, Convex or Mesh"
    )


def _half_space() -> RayPolytope:
    """Returns the points of G with z <= 0."""
    return RayPolytope(
        normals=np.array([[0.0, 0.0, 1.0]]),
        offsets=np.zeros(1),
        bounding_radius=np.inf,
        bounds=(np.full(3, -np.inf), np.array([np.inf, np.inf, 0.0])),
    )


def _make_polytope(hull: PolygonSurfaceMesh) -> RayPolytope:
    vertices = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
    normals, offsets = MakeHullPlanes(hull)
    return RayPolytope(
        normals=normals,
        offsets=offsets,
        bounding_radius=float(np.max(np.linalg.norm(vertices, axis=-1))),
        bounds=(vertices.min(axis=0), vertices.max(axis=0)),
    )


def _entry(t_in: np.ndarray, t_out: np.ndarray) -> np.ndarray:
    """Returns where a ray enters what its line is in from t_in to t_out."""
    hit = (t_in <= t_out) & (t_out >= 0)
    return np.where(hit, np.maximum(t_in, 0.0), np.inf)


def _slab_interval(
    o: np.ndarray, d: np.ndarray, half: np.ndarray | float
) -> Interval:
    """Returns when the coordinate o + t d is in [-half, half]."""
    inverse = 1.0 / np.where(d == 0, _TINY, d)
    middle, width = -o * inverse, half * np.abs(inverse)
    return middle - width, middle + width


def _ball_interval(o: np.ndarray, d: np.ndarray) -> Interval:
    """Returns when o + t d is in the unit ball; empty where it never is."""
    a = np.maximum(_dot(d, d), _TINY)
    b = _dot(o, d)
    c = _dot(o, o) - 1
    discriminant = b * b - a * c
    root = np.sqrt(np.maximum(discriminant, 0.0))
    missed = np.where(discriminant < 0, np.inf, 0.0)
    return (-b - root) / a + missed, (-b + root) / a - missed


def _dot(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Returns u · v, (...): the same bits, however u and v lie in memory."""
    total = u[..., 0] * v[..., 0]
    for i in range(1, u.shape[-1]):
        total = total + u[..., i] * v[..., i]
    return total
