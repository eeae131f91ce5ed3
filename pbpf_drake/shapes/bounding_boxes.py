"""Boxes around geometries, and how far apart they are at least.

Only what may come near an object has to be part of its simulation.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import GeometryId, SceneGraphInspector

from pbpf_drake.poses import quaternions

_CORNERS = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T


@dataclass(frozen=True)
class PlacedBoxes:
    """G boxes in the world.

    Attributes:
        bodies: (G,) which body each is part of.
        centers: (..., G, 3) (in meters).
        axes: (..., G, 3, 3) rotation matrices: the columns are the box's axes.
        half_sizes: (G, 3) along them (in meters).
    """

    bodies: np.ndarray
    centers: np.ndarray
    axes: np.ndarray
    half_sizes: np.ndarray

    def subset(self, chosen: np.ndarray) -> "PlacedBoxes":
        """Returns the boxes that are chosen, (G,) bool."""
        return PlacedBoxes(
            bodies=self.bodies[chosen],
            centers=self.centers[..., chosen, :],
            axes=self.axes[..., chosen, :, :],
            half_sizes=self.half_sizes[chosen],
        )

    def corners(self) -> np.ndarray:
        """Returns (..., G, 8, 3)."""
        offsets = (self.half_sizes[:, None] * _CORNERS) @ np.swapaxes(
            self.axes, -1, -2
        )
        return self.centers[..., None, :] + offsets


@dataclass(frozen=True)
class BoundingBoxes:
    """Boxes around the G geometries of B bodies.

    Attributes:
        bodies: (G,) which body each is part of.
        centers: (G, 3) in the frame of the body (in meters).
        axes: (G, 3, 3) rotation matrices: the columns are the box's axes.
        half_sizes: (G, 3) along them (in meters).
    """

    bodies: np.ndarray
    centers: np.ndarray
    axes: np.ndarray
    half_sizes: np.ndarray

    def at(self, X_WB: np.ndarray) -> PlacedBoxes:
        """Returns them in the world, from the bodies' poses (..., B, 7)."""
        X = X_WB[..., self.bodies, :]
        R = quaternions.to_matrix(X[..., :4])
        return PlacedBoxes(
            bodies=self.bodies,
            centers=X[..., 4:] + (R @ self.centers[..., None])[..., 0],
            axes=R @ self.axes,
            half_sizes=self.half_sizes,
        )

    def radii(self, num_bodies: int) -> np.ndarray:
        """Returns how far corners are from each body's origin, (B,)."""
        origin = np.tile([1.0, 0, 0, 0, 0, 0, 0], (num_bodies, 1))
        radii = np.zeros(num_bodies)
        corners = self.at(origin).corners()
        distances = np.linalg.norm(corners, axis=-1).max(axis=-1)
        np.maximum.at(radii, self.bodies, distances)
        return radii


def MakeBoundingBoxes(
    inspector: SceneGraphInspector, geometries: Sequence[Sequence[GeometryId]]
) -> BoundingBoxes:
    """Returns the boxes around the geometries of some bodies.

    Args:
        inspector: knows the geometries.
        geometries: of each body.

    Raises:
        ValueError: a geometry has no bounds.
    """
    rows = []
    for body, of_body in enumerate(geometries):
        for geometry in of_body:
            obb = inspector.GetObbInGeometryFrame(geometry)
            if obb is None:
                raise ValueError(
                    f"{inspector.GetName(geometry)} has no bounds; expected "
                    "a shape of finite size"
                )
            X_BO = inspector.GetPoseInFrame(geometry) @ obb.pose()
            axes = X_BO.rotation().matrix()
            rows.append((body, X_BO.translation(), axes, obb.half_width()))
    return BoundingBoxes(
        bodies=np.array([row[0] for row in rows], dtype=int),
        centers=np.reshape([row[1] for row in rows], (-1, 3)),
        axes=np.reshape([row[2] for row in rows], (-1, 3, 3)),
        half_sizes=np.reshape([row[3] for row in rows], (-1, 3)),
    )


def least_distances(a: PlacedBoxes, b: PlacedBoxes) -> np.ndarray:
    """Returns how far apart boxes are at least, (..., Ga, Gb).

    It is the widest gap along an axis of one of the two: never more than the
    distance, and less than 0 where they overlap.
    """
    num_b = len(b.half_sizes)
    to_a = np.swapaxes(a.axes, -1, -2)
    columns = np.swapaxes(b.axes, -3, -2).reshape(
        *b.axes.shape[:-3], 1, 3, 3 * num_b
    )
    # [..., a, i, b, j]: axis j of each box of b, along axis i of one of a.
    R = to_a @ columns
    R = R.reshape(*R.shape[:-1], num_b, 3)
    d = b.centers[..., None, :, :] - a.centers[..., :, None, :]
    d_a = to_a @ np.swapaxes(d, -1, -2)  # [..., a, i, b]
    d_b = (R * d_a[..., None]).sum(axis=-3)  # [..., a, b, j]
    R, half_a = np.abs(R), a.half_sizes[..., None]
    gap_a = np.abs(d_a) - half_a - np.einsum("...bj,bj->...b", R, b.half_sizes)
    half_a_along_b = (R * half_a[..., None]).sum(axis=-3)
    gap_b = np.abs(d_b) - b.half_sizes - half_a_along_b
    return np.maximum(gap_a.max(axis=-2), gap_b.max(axis=-1))
