"""Random points on the surface of Drake's shapes, uniform over its area.

Visibility is measured at them (Section 4.3). Each point by itself is uniform
over the area. The points of one draw aren't independent, however: they come
from a lattice of evenly spaced points that is shifted at random. A mean over
the surface has the same expectation as with independent points, and it scatters
much less.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    PolygonSurfaceMesh,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform

# The root of x^3 = x + 1. The n points (i/n, i/_ROOT, i/_ROOT^2), modulo 1,
# fill the unit cube evenly, whatever n is.
_ROOT = 1.324717957244746


class Surface(Protocol):
    """The surface of one shape, in the shape's frame G.

    Attributes:
        area: its area (in m^2).
    """

    @property
    def area(self) -> float: ...

    def sample(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """Returns n points (in meters), (n, 3), uniform over the area."""
        ...


@dataclass(frozen=True, eq=False)
class BoxSurface:
    """The surface of a box with its centre in G's origin."""

    # Half of the edges' lengths (in meters), (3,).
    half_size: np.ndarray

    @property
    def area(self) -> float:
        """See Surface."""
        return float(2 * np.sum(self._face_areas()))

    def sample(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """See Surface."""
        u = _draw_lattice(rng, n)
        face = _choose(np.tile(self._face_areas(), 2), u[:, 0])
        across = face % 3
        rows = np.arange(n)
        unit = np.empty((n, 3))
        unit[rows, across] = np.where(face < 3, 1.0, -1.0)
        unit[rows, (across + 1) % 3] = 2 * u[:, 1] - 1
        unit[rows, (across + 2) % 3] = 2 * u[:, 2] - 1
        return unit * self.half_size

    def _face_areas(self) -> np.ndarray:
        return 4 * np.prod(self.half_size) / self.half_size


@dataclass(frozen=True, eq=False)
class EllipsoidSurface:
    """The surface of an ellipsoid, or a sphere, centred in G's origin."""

    # The half axes (in meters), (3,).
    radii: np.ndarray

    @property
    def area(self) -> float:
        """See Surface."""
        # At the top of the file, this would take a third of the time that it
        # takes to import the package.
        from scipy.special import elliprg

        return float(
            4 * np.pi * elliprg(*(np.prod(self.radii) / self.radii) ** 2)
        )

    def sample(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """See Surface."""
        # Points of the unit sphere are stretched onto the ellipsoid. The more
        # the surface around a point is stretched, the likelier the point is
        # kept: for sure where that is most, which is at the smallest radius.
        largest = 1 / np.min(self.radii)
        unit = np.empty((n, 3))
        missing = np.arange(n)
        while missing.size:
            u = _draw_lattice(rng, n)[missing]
            tried = _ball_points(u[:, 0], u[:, 1])
            stretch = np.linalg.norm(tried / self.radii, axis=-1)
            accepted = u[:, 2] * largest <= stretch
            unit[missing[accepted]] = tried[accepted]
            missing = missing[~accepted]
        return unit * self.radii


@dataclass(frozen=True, eq=False)
class CylinderSurface:
    """The surface of a cylinder along G's z axis, ends included."""

    radius: float
    length: float

    @property
    def area(self) -> float:
        """See Surface."""
        return float(np.sum(self._part_areas()))

    def sample(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """See Surface."""
        u = _draw_lattice(rng, n)
        part = _choose(self._part_areas(), u[:, 0])
        height = np.stack([2 * u[:, 1] - 1, np.ones(n), -np.ones(n)])
        distance = np.where(part == 0, 1.0, np.sqrt(u[:, 1]))
        angle = 2 * np.pi * u[:, 2]
        return np.stack(
            [
                self.radius * distance * np.cos(angle),
                self.radius * distance * np.sin(angle),
                0.5 * self.length * height[part, np.arange(n)],
            ],
            axis=-1,
        )

    def _part_areas(self) -> np.ndarray:
        end = np.pi * self.radius**2
        return np.array([2 * np.pi * self.radius * self.length, end, end])


@dataclass(frozen=True, eq=False)
class CapsuleSurface:
    """The surface of a capsule along G's z axis."""

    radius: float
    # Length of the cylinder between the half spheres (in meters).
    length: float

    @property
    def area(self) -> float:
        """See Surface."""
        return 2 * np.pi * self.radius * (self.length + 2 * self.radius)

    def sample(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """See Surface."""
        u = _draw_lattice(rng, n)
        # Slices of equal height have equal areas on a ball and on a cylinder
        # of its radius. So z is uniform, over a ball whose halves are apart.
        z = (2 * u[:, 0] - 1) * (0.5 * self.length + self.radius)
        middle = np.clip(z, -0.5 * self.length, 0.5 * self.length)
        unit = _ball_points(0.5 + 0.5 * (z - middle) / self.radius, u[:, 1])
        return unit * self.radius + middle[:, None] * [0.0, 0.0, 1.0]


@dataclass(frozen=True, eq=False)
class TriangleSurface:
    """A surface of triangles."""

    # The corners in G (in meters), (T, 3, 3).
    corners: np.ndarray

    @property
    def area(self) -> float:
        """See Surface."""
        return float(np.sum(self._areas()))

    def sample(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """See Surface."""
        u = _draw_lattice(rng, n)
        a, b, c = np.moveaxis(
            self.corners[_choose(self._areas(), u[:, 0])], 1, 0
        )
        outwards, along = np.sqrt(u[:, 1:2]), u[:, 2:3]
        return a + outwards * (b - a + along * (c - b))

    def _areas(self) -> np.ndarray:
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=-1)


class BodySurface:
    """The surfaces of all shapes of one body.

    Where shapes overlap, the parts inside of another shape count as well.
    """

    def __init__(
        self, *, shapes: Sequence[Shape], X_BG: Sequence[RigidTransform]
    ):
        """Takes the shapes, at least one, and their poses in the body.

        Raises:
            ValueError: a shape has no surface of a finite area.
        """
        self._surfaces = [MakeSurface(shape) for shape in shapes]
        self._areas = np.array([surface.area for surface in self._surfaces])
        self._X_BG = list(X_BG)

    @property
    def area(self) -> float:
        """The sum of the shapes' areas (in m^2)."""
        return float(np.sum(self._areas))

    def sample(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """Returns n points in the body's frame (in meters), (n, 3).

        Every shape gets its share of the points by area.
        """
        chosen = _choose(self._areas, _draw_lattice(rng, n)[:, 0])
        points = np.empty((n, 3))
        for i in np.unique(chosen):
            X, mine = self._X_BG[i], chosen == i
            p_GT = self._surfaces[i].sample(rng, np.count_nonzero(mine))
            points[mine] = p_GT @ X.rotation().matrix().T + X.translation()
        return points


def MakeSurface(shape: Shape) -> Surface:
    """Returns the surface of ``shape``; of a mesh, its convex hull's.

    Raises:
        ValueError: the shape has no surface of a finite area.
        RuntimeError: the file of a mesh can't be read.
    """
    match shape:
        case Box():
            return BoxSurface(0.5 * np.asarray(shape.size()))
        case Sphere():
            return EllipsoidSurface(np.full(3, shape.radius()))
        case Ellipsoid():
            return EllipsoidSurface(np.array([shape.a(), shape.b(), shape.c()]))
        case Cylinder():
            return CylinderSurface(shape.radius(), shape.length())
        case Capsule():
            return CapsuleSurface(shape.radius(), shape.length())
        case Convex() | Mesh():
            return TriangleSurface(_triangles(shape.GetConvexHull()))
    raise ValueError(
        f"{shape} has no surface of a finite area; expected a Box, Sphere, "
        "Ellipsoid, Cylinder, Capsule, Convex or Mesh"
    )


def _triangles(hull: PolygonSurfaceMesh) -> np.ndarray:
    """Returns the hull's faces, cut into triangles, (T, 3, 3)."""
    triangles = []
    for f in range(hull.num_faces()):
        face = hull.element(f)
        corners = [
            hull.vertex(face.vertex(i)) for i in range(face.num_vertices())
        ]
        for b, c in zip(corners[1:-1], corners[2:], strict=True):
            triangles.append([corners[0], b, c])
    return np.array(triangles)


def _draw_lattice(rng: np.random.Generator, n: int) -> np.ndarray:
    """Draws n evenly spaced points of the unit cube, (n, 3)."""
    step = np.array([1 / n, 1 / _ROOT, 1 / _ROOT**2])
    return (rng.random(3) + np.arange(n)[:, None] * step) % 1.0


def _choose(areas: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Returns an index for every u in [0, 1): larger areas come more often."""
    edges = np.cumsum(areas)
    return np.searchsorted(edges[:-1], u * edges[-1], side="right")


def _ball_points(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Returns points of the unit sphere, (n, 3), uniform for uniform u, v."""
    z = 2 * u - 1
    distance, angle = np.sqrt(np.maximum(1 - z * z, 0.0)), 2 * np.pi * v
    return np.stack(
        [distance * np.cos(angle), distance * np.sin(angle), z], axis=-1
    )
