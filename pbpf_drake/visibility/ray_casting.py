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

from pbpf_drake.poses import quaternions
from pbpf_drake.visibility.ray_culling import (
    along,
    coordinates,
    may_enter_box,
    may_hit_ball,
    may_hit_balls,
)
from pbpf_drake.visibility.ray_shapes import MakeRayShape


class OccluderSet:
    """Geometries that are at the same place for all rays, such as a robot's.

    It never changes. It keeps the shapes, so each cast only needs their poses.
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
        num_rays = targets.shape[-2] if targets.ndim > 1 else 1
        ways = coordinates((targets - origin).reshape(-1, num_rays, 3))
        X_WG = [query_object.GetPoseInWorld(id) for id in self._ids]
        p_OG = np.array([X.translation() for X in X_WG]) - origin
        near = may_hit_balls(ways, p_OG[:, None], self._radii[:, None])
        rays = np.arange(first.size).reshape(ways.shape[1:])
        t = first.reshape(-1)
        for i in np.flatnonzero(near.any(axis=1)).tolist():
            some = near[i] if not near[i].all() else slice(None)
            chosen, t_hit = self._CastAt(
                i, X_WG[i], p_OG[i], ways[:, some].reshape(3, -1)
            )
            hit = rays[some].reshape(-1)[chosen]
            t[hit] = np.minimum(t[hit], t_hit)
        return np.where(first <= 1, first, np.inf)

    def _CastAt(
        self, i: int, X_WG: RigidTransform, p_OG: np.ndarray, d: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns which rays may hit a geometry, (n,), and their t, (n,).

        Args:
            i: which geometry.
            X_WG: its pose.
            p_OG: (3,) from the rays' origin to it, in the world.
            d: (3, N) from the rays' origin to their targets.
        """
        shape, R_WG = self._shapes[i], X_WG.rotation().matrix()
        o = -p_OG @ R_WG
        may_hit = may_enter_box(d, o, R_WG, shape.bounds)
        may_hit &= may_hit_ball(d, p_OG, shape.bounding_radius)
        chosen = np.flatnonzero(may_hit)
        if not len(chosen):
            return chosen, np.zeros(0)
        return chosen, shape.intersect(o, _turned(d[:, chosen], R_WG))


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
        # The radius (in meters) of a ball around B's origin that holds it.
        self.bounding_radius = max(
            (
                float(np.linalg.norm(p_BG)) + shape.bounding_radius
                for shape, _, p_BG in self._shapes
            ),
            default=0.0,
        )

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
        num_rays = int(np.prod(targets.shape[1:-1]))
        d = coordinates((targets - origin).reshape(len(poses), num_rays, 3))
        t = np.full(d.shape[1:], np.inf)
        for shape, R_BG, p_BG in self._shapes:
            d_G = _turned(d, (R_WB @ R_BG)[:, None])
            hits = shape.intersect((o_B - p_BG) @ R_BG, d_G)
            t = np.minimum(t, hits)
        return t.reshape(targets.shape[:-1])


def _turned(d: np.ndarray, R: np.ndarray) -> np.ndarray:
    """Returns vectors in another frame, (..., 3).

    Args:
        d: (3, ...) the vectors in a frame A.
        R: (..., 3, 3) R_AB of the other frame B.
    """
    turned = np.stack([along(d, R[..., i]) for i in range(3)])
    return np.moveaxis(turned, 0, -1)
