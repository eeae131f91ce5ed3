"""Boxes around geometries, and lower bounds of the distances between them.

They tell what may come near an object: only that has to be part of its
simulation.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import GeometryId, SceneGraphInspector

from pbpf_drake.poses import quaternions
from pbpf_drake.shapes.box_corners import box_corners


@dataclass(frozen=True)
class PlacedBoxes:
    """G boxes in the world.

    Attributes:
        bodies: (G,) the index of the body that each is part of.
        centers: (..., G, 3) (in meters).
        axes: (..., G, 3, 3) rotation matrices: the columns are the box's axes.
        half_sizes: (G, 3) along them (in meters).
    """

    bodies: np.ndarray
    centers: np.ndarray
    axes: np.ndarray
    half_sizes: np.ndarray

    def subset(self, chosen: np.ndarray) -> "PlacedBoxes":
        """Returns some of the boxes.

        Args:
            chosen: (G,) bool, which ones.
        """
        return PlacedBoxes(
            bodies=self.bodies[chosen],
            centers=self.centers[..., chosen, :],
            axes=self.axes[..., chosen, :, :],
            half_sizes=self.half_sizes[chosen],
        )

    def corners(self) -> np.ndarray:
        """Returns the boxes' corners (in meters), (..., G, 8, 3)."""
        offsets = box_corners(self.half_sizes) @ np.swapaxes(self.axes, -1, -2)
        return self.centers[..., None, :] + offsets


@dataclass(frozen=True)
class BoundingBoxes:
    """Boxes around the G geometries of B bodies.

    Attributes:
        bodies: (G,) the index of the body that each is part of.
        centers: (G, 3) in the frame of the body (in meters).
        axes: (G, 3, 3) rotation matrices: the columns are the box's axes.
        half_sizes: (G, 3) along them (in meters).
    """

    bodies: np.ndarray
    centers: np.ndarray
    axes: np.ndarray
    half_sizes: np.ndarray

    def at(self, X_WB: np.ndarray) -> PlacedBoxes:
        """Returns the boxes in the world.

        Args:
            X_WB: (..., B, 7) the bodies' poses.
        """
        X = X_WB[..., self.bodies, :]
        R = quaternions.to_matrix(X[..., :4])
        return PlacedBoxes(
            bodies=self.bodies,
            centers=X[..., 4:] + (R @ self.centers[..., None])[..., 0],
            axes=R @ self.axes,
            half_sizes=self.half_sizes,
        )

    def radii(self, num_bodies: int) -> np.ndarray:
        """Returns how far each body reaches from its origin (in meters), (B,).

        That is the distance of the farthest corner of its boxes, and 0 for a
        body without any.

        Args:
            num_bodies: B.
        """
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
        geometries: those of each body.

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
    """Returns lower bounds of the distances of boxes, (..., Ga, Gb).

    A bound (in meters) is the widest gap between two boxes along any axis of
    either. It is never more than their distance, and it is negative where they
    overlap.
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
