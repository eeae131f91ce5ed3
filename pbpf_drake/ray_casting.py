"""Ray casting on the proximity geometry of a SceneGraph.

Drake's QueryObject casts no rays. Here every ray meets every shape that the
SceneGraph's inspector has, at the pose that the query object has, exactly.
All rays of a call start at one point, and each ends at its target: t is 0 at
the origin and 1 at the target.
"""

from collections.abc import Iterable, Sequence

import numpy as np
from pydrake.geometry import (
    GeometryId,
    QueryObject,
    SceneGraphInspector,
    Shape,
)
from pydrake.math import RigidTransform

from pbpf_drake import quaternions
from pbpf_drake.ray_shapes import MakeRayShape


class OccluderSet:
    """Geometries that are the same for all rays, such as a robot's.

    It keeps the shapes, so that casting again only asks for their poses. It
    never changes.
    """

    def __init__(
        self,
        *,
        inspector: SceneGraphInspector,
        geometry_ids: Iterable[GeometryId],
    ):
        """Takes the geometries, of any source and with any role.

        Raises:
            ValueError: no ray can be cast at a geometry's shape.
        """
        self._ids = list(geometry_ids)
        self._shapes = [
            MakeRayShape(inspector.GetShape(id)) for id in self._ids
        ]
        self._radii = np.array([s.bounding_radius for s in self._shapes])

    def Cast(
        self,
        *,
        query_object: QueryObject,
        origin: np.ndarray,
        targets: np.ndarray,
    ) -> np.ndarray:
        """Returns what is first hit on the way to each target.

        Args:
            query_object: tells the geometries' poses in the world.
            origin: where all rays start, in the world (in meters), (3,).
            targets: where they end, in the world (in meters), (..., 3).

        Returns:
            The parameter t of the first hit, (...): in [0, 1], or inf where
            the target is reached. 0 means that the origin is inside.
        """
        first = np.full(targets.shape[:-1], np.inf)
        if not self._ids or not first.size:
            return first
        X_WG = [query_object.GetPoseInWorld(id) for id in self._ids]
        p_OG = np.array([X.translation() for X in X_WG]) - origin
        ways = targets - origin
        d = ways.reshape(-1, 3)
        may_hit = np.flatnonzero(_near_cone(d, p_OG, self._radii))
        near = _near_balls(ways, p_OG[may_hit], self._radii[may_hit])
        t = first.reshape(-1)
        for i, rays_near in zip(
            may_hit, near.reshape(len(d), -1).T, strict=True
        ):
            rays = np.flatnonzero(rays_near)
            if not len(rays):
                continue
            R_WG = X_WG[i].rotation().matrix()
            hits = self._shapes[i].intersect(
                -p_OG[i] @ R_WG, _turned(d[rays], R_WG)
            )
            t[rays] = np.minimum(t[rays], hits)
        return np.where(first <= 1, first, np.inf)


def CastRays(
    *,
    query_object: QueryObject,
    geometry_ids: Iterable[GeometryId],
    origin: np.ndarray,
    targets: np.ndarray,
) -> np.ndarray:
    """Casts rays at geometries once; see OccluderSet.Cast.

    To cast at the same geometries again and again, keep an OccluderSet.
    """
    occluders = OccluderSet(
        inspector=query_object.inspector(), geometry_ids=geometry_ids
    )
    return occluders.Cast(
        query_object=query_object, origin=origin, targets=targets
    )


class RayBody:
    """All shapes of one body, to be hit at many poses of it at once."""

    def __init__(
        self, *, shapes: Sequence[Shape], X_BG: Sequence[RigidTransform]
    ):
        """Takes the shapes and their poses in the body.

        Raises:
            ValueError: no ray can be cast at a shape.
        """
        self._shapes = [
            (MakeRayShape(shape), X.rotation().matrix(), X.translation())
            for shape, X in zip(shapes, X_BG, strict=True)
        ]

    def Cast(
        self, *, poses: np.ndarray, origin: np.ndarray, targets: np.ndarray
    ) -> np.ndarray:
        """Returns where the rays of particle m hit the body of particle m.

        Args:
            poses: (M, 7 or more), the body's poses X_WB: qw qx qy qz (of unit
                length), x y z (in meters); what follows is not used.
            origin: where all rays start, in the world (in meters), (3,).
            targets: where they end, in the world (in meters), (M, ..., 3).

        Returns:
            The parameter t of the first hit, (M, ...): inf where there is
            none, not even beyond the target; 0 where the origin is inside.
        """
        # Row i is the world's axis i of the rotated body: R_BW.
        R_BW = quaternions.rotate(poses[:, None, :4], np.eye(3))
        R_WB = np.swapaxes(R_BW, 1, 2)
        o_B = (origin - poses[:, None, 4:7]) @ R_WB
        d_B = (targets - origin).reshape(len(poses), -1, 3) @ R_WB
        t = np.full(d_B.shape[:-1], np.inf)
        for shape, R_BG, p_BG in self._shapes:
            hits = shape.intersect((o_B - p_BG) @ R_BG, d_B @ R_BG)
            t = np.minimum(t, hits)
        return t.reshape(targets.shape[:-1])


def _near_cone(
    d: np.ndarray, p_OG: np.ndarray, radii: np.ndarray
) -> np.ndarray:
    """Returns which balls any ray from 0 along d (N, 3) may hit, (G,).

    All targets are within ρ of their middle, so all rays are within ρ of the
    line to there.
    """
    middle = d.mean(axis=0)
    spread = np.sqrt(np.max(np.sum((d - middle) ** 2, axis=-1)))
    u = p_OG @ middle / max(middle @ middle, 1e-300)
    nearest = np.clip(u, 0.0, 1.0)[:, None] * middle
    return np.linalg.norm(p_OG - nearest, axis=-1) <= radii + spread + 1e-6


def _near_balls(
    d: np.ndarray, p_OG: np.ndarray, radii: np.ndarray
) -> np.ndarray:
    """Returns which rays from 0 along d may hit which ball, (..., N, G).

    The product of a large matrix would wake the threads of numpy's BLAS, which
    then keep the other cores busy for a while; those of small ones don't.

    Args:
        d: (..., N, 3), with a small N.
        p_OG: (G, 3) the balls' centres.
        radii: (G,).
    """
    length = np.linalg.norm(d, axis=-1, keepdims=True)
    distance = np.linalg.norm(p_OG, axis=-1)
    # From outside, a ray that touches the ball has come this far; the slack
    # is far above rounding errors.
    tangent = np.sqrt(np.maximum(distance**2 - radii**2, 0.0)) - 1e-6
    tangent[distance <= radii] = -np.inf
    tangent[distance - radii > np.max(length) + 1e-6] = np.inf
    return (d / np.maximum(length, 1e-300)) @ p_OG.T >= tangent


def _turned(d: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Returns d @ R, (N, 3): the same bits, however many rays there are."""
    return d[:, :1] * R[0] + d[:, 1:2] * R[1] + d[:, 2:] * R[2]
