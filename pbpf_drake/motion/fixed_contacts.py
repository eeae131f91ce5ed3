"""Where objects touch fixed models, for all particles at once.

Things stand on the small spheres of contact_points.py. So in a contact a sphere
of an object touches a fixed shape, or a sphere of a fixed model touches an
object's shape. The particle plant has the same spheres and shapes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import GeometryId
from pydrake.math import RigidTransform

from pbpf_drake.poses import quaternions
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.scene.prediction_model import PredictionModel
from pbpf_drake.shapes.bounding_boxes import MakeBoundingBoxes
from pbpf_drake.shapes.contact_points import MakeContactPoints
from pbpf_drake.shapes.signed_distance import MakeSignedDistance, SignedDistance


@dataclass(frozen=True)
class PointContacts:
    """Contacts of n spheres, in no particular order.

    Attributes:
        particles: (n,) the index m of the particle.
        objects: (n,) the index k of the object in it.
        points: (n, 3) where they touch, in the world (in meters).
        normals: (n, 3) unit normals there, towards the object.
        depths: (n,) how deep they penetrate (in meters), more than 0.
    """

    particles: np.ndarray
    objects: np.ndarray
    points: np.ndarray
    normals: np.ndarray
    depths: np.ndarray


@dataclass(frozen=True)
class _Solid:
    """A shape and its spheres, in the frame of its body (or the world)."""

    X_BG: RigidTransform
    distance: SignedDistance
    p_BP: np.ndarray
    radius: float

    def Distance(self, p_B: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns distances and normals of points (..., 3), all in B."""
        R = self.X_BG.rotation().matrix()
        distance, normal = self.distance((p_B - self.X_BG.translation()) @ R)
        return distance, normal @ R.T


class FixedContacts:
    """Finds the contacts of a scene's objects with its fixed models.

    Args:
        model: the scene's models.
    """

    def __init__(self, model: PredictionModel) -> None:
        self._inspector = model.diagram.scene_graph().model_inspector()
        objects = model.models.objects
        boxes = MakeBoundingBoxes(
            self._inspector, [model.geometries(body) for body in objects]
        )
        # Of balls around all geometry of each object, its spheres included.
        self._radii = boxes.radii(len(objects)) + 1e-3
        fixed = {
            geometry: self._MakeSolid(geometry, rigid_transform(pose))
            for body, pose in zip(
                model.models.fixed, model.fixed_poses(), strict=True
            )
            for geometry in model.geometries(body)
        }
        self._pairs: list[tuple[int, _Solid, _Solid]] = []
        for k, body in enumerate(objects):
            for geometry in model.geometries(body):
                solid = self._MakeSolid(geometry, RigidTransform())
                self._pairs += [
                    (k, solid, other)
                    for id, other in fixed.items()
                    if not self._inspector.CollisionFiltered(id, geometry)
                ]

    def Find(self, poses: np.ndarray) -> PointContacts:
        """Returns the contacts of all objects of all particles.

        Args:
            poses: (M, K, 7); what isn't finite touches nothing.
        """
        found = [
            contacts
            for k, solid, fixed in self._pairs
            for contacts in self._Touch(k, solid, fixed, poses[:, k])
        ]
        indices, vectors = np.zeros(0, int), np.zeros((0, 3))
        found.append((indices, indices, vectors, vectors, np.zeros(0)))
        particles, objects, points, normals, depths = (
            np.concatenate(column) for column in zip(*found, strict=True)
        )
        return PointContacts(
            particles=particles,
            objects=objects,
            points=points,
            normals=normals,
            depths=depths,
        )

    def _MakeSolid(self, geometry: GeometryId, X_BS: RigidTransform) -> _Solid:
        shape = self._inspector.GetShape(geometry)
        X_BG = X_BS @ self._inspector.GetPoseInFrame(geometry)
        points = MakeContactPoints(shape)
        return _Solid(
            X_BG=X_BG,
            distance=MakeSignedDistance(shape),
            p_BP=(X_BG @ points.p_GS.T).T.reshape(-1, 3),
            radius=points.radius,
        )

    def _Touch(
        self, k: int, solid: _Solid, fixed: _Solid, X_WO: np.ndarray
    ) -> Iterator[tuple[np.ndarray, ...]]:
        """Yields the columns of PointContacts of one pair of geometries."""
        radius = self._radii[k]
        near = np.flatnonzero(fixed.Distance(X_WO[:, 4:])[0] <= radius)
        if not len(near):
            return
        # From the right, these turn vectors from W into O and back.
        to_O = quaternions.to_matrix(X_WO[near, :4])
        to_W, p_WO = np.swapaxes(to_O, -1, -2), X_WO[near, None, 4:]
        p_WP = p_WO + solid.p_BP @ to_W
        distance, normal = fixed.Distance(p_WP)
        yield _columns(near, k, p_WP, normal, solid.radius - distance)
        in_reach = np.linalg.norm(fixed.p_BP - p_WO, axis=-1) <= radius
        points = np.flatnonzero(in_reach.any(axis=0))
        if not len(points):
            return
        p_WP = np.broadcast_to(fixed.p_BP[points], (len(near), len(points), 3))
        distance, normal = solid.Distance((p_WP - p_WO) @ to_O)
        yield _columns(near, k, p_WP, -normal @ to_W, fixed.radius - distance)


def _columns(
    particles: np.ndarray,
    k: int,
    points: np.ndarray,
    normals: np.ndarray,
    depths: np.ndarray,
) -> tuple[np.ndarray, ...]:
    row, column = np.nonzero(depths > 0)
    return (
        particles[row],
        np.full(len(row), k),
        points[row, column],
        normals[row, column],
        depths[row, column],
    )
