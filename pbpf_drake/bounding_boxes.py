"""Boxes around geometries, and how far apart they are at least.

Only what may come near an object has to be part of its simulation.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from pydrake.geometry import GeometryId, SceneGraphInspector

from pbpf_drake import quaternions

_CORNERS = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T


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

    def subset(self, chosen: np.ndarray) -> "BoundingBoxes":
        """Returns the boxes that are chosen, (G,) bool."""
        return BoundingBoxes(
            *(getattr(self, f.name)[chosen] for f in fields(self))
        )

    def frames(self, X_WB: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns centers (..., G, 3) and axes (..., G, 3, 3) in the world.

        Args:
            X_WB: (..., B, 7) poses of the bodies.
        """
        X = X_WB[..., self.bodies, :]
        R = quaternions.to_matrix(X[..., :4])
        centers = X[..., 4:] + (R @ self.centers[..., None])[..., 0]
        return centers, R @ self.axes

    def corners(self, X_WB: np.ndarray) -> np.ndarray:
        """Returns (..., G, 8, 3) in the world, from X_WB (..., B, 7)."""
        centers, axes = self.frames(X_WB)
        offsets = (self.half_sizes[:, None] * _CORNERS) @ np.swapaxes(
            axes, -1, -2
        )
        return centers[..., None, :] + offsets

    def radii(self, num_bodies: int) -> np.ndarray:
        """Returns how far corners are from each body's origin, (B,)."""
        origin = np.tile([1.0, 0, 0, 0, 0, 0, 0], (num_bodies, 1))
        radii = np.zeros(num_bodies)
        distances = np.linalg.norm(self.corners(origin), axis=-1).max(axis=-1)
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


def least_distances(
    a: BoundingBoxes, X_WA: np.ndarray, b: BoundingBoxes, X_WB: np.ndarray
) -> np.ndarray:
    """Returns how far apart boxes are at least, (..., Ga, Gb).

    It is the widest gap along an axis of one of the two: never more than the
    distance, and less than 0 where they overlap.

    Args:
        a, b: Ga and Gb boxes.
        X_WA, X_WB: (..., B, 7) poses of their bodies.
    """
    p_a, R_a = a.frames(X_WA)
    p_b, R_b = b.frames(X_WB)
    d = p_b[..., None, :, :] - p_a[..., :, None, :]
    # [..., i, j]: axis i of a box of a, along axis j of a box of b.
    R_ab = (
        np.swapaxes(R_a, -1, -2)[..., :, None, :, :] @ R_b[..., None, :, :, :]
    )
    R_ab = np.abs(R_ab)
    d_a = np.abs(np.swapaxes(R_a, -1, -2)[..., :, None, :, :] @ d[..., None])
    d_b = np.abs(np.swapaxes(R_b, -1, -2)[..., None, :, :, :] @ d[..., None])
    half_a, half_b = a.half_sizes[:, None, :, None], b.half_sizes[..., None]
    gap_a = d_a - half_a - R_ab @ half_b
    gap_b = d_b - half_b - np.swapaxes(R_ab, -1, -2) @ half_a
    return np.maximum(gap_a, gap_b).max(axis=(-2, -1))
