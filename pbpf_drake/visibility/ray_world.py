"""The world of a scene that rays are cast in, from its camera.

It is built from the scene file. It holds what the models have with the
proximity role, exactly as the files say it.
"""

from collections.abc import Iterable

import numpy as np
from pydrake.geometry import GeometryId, QueryObject
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram, RobotDiagramBuilder
from pydrake.systems.framework import Context

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.pinhole import in_camera, in_image
from pbpf_drake.scene.scene_models import AddSceneModels
from pbpf_drake.shapes.surface_sampling import BodySurface
from pbpf_drake.visibility.ray_casting import CastRays, OccluderSet, RayBody
from pbpf_drake.visibility.ray_culling import coordinates, may_hit_balls


class RayWorld:
    """A scene's robot, fixed models and tracked objects, for rays to hit.

    It never changes. Whoever casts rays in it needs a context of their own.
    """

    def __init__(self, scene: Scene):
        """Builds the world of a scene.

        Raises:
            ValueError: the scene's models don't fit their roles, a tracked
                object has no collision geometry, or the camera is inside a
                fixed model, which hides everything.
        """
        self._camera = scene.camera
        self._origin = np.array(scene.camera.pose().translation())
        builder = RobotDiagramBuilder(time_step=0.0)
        models = AddSceneModels(builder.plant(), scene)
        self._diagram: RobotDiagram = builder.Build()
        self._robot = models.robot
        self._inspector = self._diagram.scene_graph().model_inspector()
        fixed = self._Geometries(models.fixed)
        self._CheckCamera(scene, fixed)
        robot = self._diagram.plant().GetBodyIndices(models.robot)
        self._occluders = OccluderSet(
            inspector=self._inspector,
            geometry_ids=fixed + self._Geometries(robot),
        )
        self._bodies: list[RayBody] = []
        self._surfaces: list[BodySurface] = []
        for name, body in zip(
            scene.object_names(), models.objects, strict=True
        ):
            self._AddObject(scene, name, body)

    def surfaces(self) -> list[BodySurface]:
        """Returns the surfaces of the objects, in the scene's order."""
        return self._surfaces

    def MakeContext(self) -> Context:
        """Returns what CalcSeenShares may overwrite."""
        return self._diagram.CreateDefaultContext()

    def CalcSeenShares(
        self,
        particles: np.ndarray,
        *,
        tracked: np.ndarray,
        p_OT: np.ndarray,
        robot_positions: np.ndarray,
        context: Context,
    ) -> np.ndarray:
        """Returns the share of points on objects that is seen, (m, T).

        Args:
            particles: (m, T, 7 or more) the poses X_WO of the tracked objects:
                qw qx qy qz (of unit length), x y z (in meters); what follows
                is not used.
            tracked: (T,) the indices of these objects.
            p_OT: (T, R, 3) points on their surfaces (in meters).
            robot_positions: (n,) the robot's joint positions.
            context: from MakeContext; what is in it does not matter.
        """
        p_WT = particles[:, :, None, 4:7] + quaternions.rotate(
            particles[:, :, None, :4], p_OT
        )
        seen = in_image(in_camera(p_WT, self._camera), self._camera)
        seen &= self._Reached(
            particles, tracked, p_WT, robot_positions, context
        )
        return np.mean(seen, axis=-1)

    def _Reached(
        self,
        particles: np.ndarray,
        tracked: np.ndarray,
        p_WT: np.ndarray,
        robot_positions: np.ndarray,
        context: Context,
    ) -> np.ndarray:
        """Returns which rays enter their own object first, (m, T, R)."""
        hidden_at = self._CastAtRobotAndFixed(p_WT, robot_positions, context)
        own = np.empty_like(hidden_at)
        may_hide = self._MayHide(particles, tracked, p_WT)
        for k, body in enumerate(tracked):
            own[:, k] = self._bodies[body].Cast(
                poses=particles[:, k], origin=self._origin, targets=p_WT[:, k]
            )
            m, other = np.nonzero(may_hide[k])
            if not len(m):
                continue
            t = self._bodies[body].Cast(
                poses=particles[m, k],
                origin=self._origin,
                targets=p_WT[m, other],
            )
            hidden_at[m, other] = np.minimum(hidden_at[m, other], t)
        return own <= hidden_at

    def _MayHide(
        self, particles: np.ndarray, tracked: np.ndarray, p_WT: np.ndarray
    ) -> np.ndarray:
        """Returns which object may hide anything of which other, (T, m, T)."""
        num_tracked = len(tracked)
        if num_tracked == 1:
            return np.zeros((1, len(particles), 1), dtype=bool)
        radii = np.array([self._bodies[k].bounding_radius for k in tracked])
        p_WO = np.swapaxes(particles[..., 4:7], 0, 1)
        near = may_hit_balls(
            coordinates((p_WT - self._origin).reshape(-1, *p_WT.shape[2:])),
            np.repeat(p_WO - self._origin, num_tracked, axis=1),
            radii[:, None],
        ).reshape(num_tracked, *p_WT.shape[:2])
        itself = np.arange(num_tracked)
        near[itself, :, itself] = False
        return near

    def _CastAtRobotAndFixed(
        self, p_WT: np.ndarray, robot_positions: np.ndarray, context: Context
    ) -> np.ndarray:
        """Returns t of the first hit, (M, K, R), or inf."""
        plant = self._diagram.plant()
        plant.SetPositions(
            self._diagram.mutable_plant_context(context),
            self._robot,
            robot_positions,
        )
        return self._occluders.Cast(
            query_object=self._QueryObject(context),
            origin=self._origin,
            targets=p_WT,
        )

    def _QueryObject(self, context: Context) -> QueryObject:
        return (
            self._diagram.scene_graph()
            .get_query_output_port()
            .Eval(self._diagram.scene_graph_context(context))
        )

    def _Geometries(self, bodies: Iterable[BodyIndex]) -> list[GeometryId]:
        plant = self._diagram.plant()
        return [
            geometry
            for body in bodies
            for geometry in plant.GetCollisionGeometriesForBody(
                plant.get_body(body)
            )
        ]

    def _CheckCamera(self, scene: Scene, fixed: list[GeometryId]) -> None:
        query_object = self._QueryObject(self.MakeContext())
        for geometry in fixed:
            t = CastRays(
                query_object=query_object,
                geometry_ids=[geometry],
                origin=self._origin,
                targets=self._origin,
            )
            if np.isfinite(t):
                raise ValueError(
                    f"Scene {scene.path}: camera.X_WC is inside the geometry "
                    f"{self._inspector.GetName(geometry)}, which hides "
                    "everything; expected a camera in free space"
                )

    def _AddObject(self, scene: Scene, name: str, body: BodyIndex) -> None:
        geometries = self._Geometries([body])
        if not geometries:
            raise ValueError(
                f"Scene {scene.path}: tracked model {name!r} has no collision "
                "geometry, so it can't be pushed or seen; expected at least "
                "one <collision> in its file: a box, a cylinder or a mesh"
            )
        shapes = [self._inspector.GetShape(g) for g in geometries]
        X_BG = [self._inspector.GetPoseInFrame(g) for g in geometries]
        self._bodies.append(RayBody(shapes=shapes, X_BG=X_BG))
        self._surfaces.append(BodySurface(shapes=shapes, X_BG=X_BG))
