"""How visible particles are to the camera, and what that says (Section 4.3).

The world that rays are cast in is built from the scene file. It holds what
the models have with the proximity role, exactly as the files say it.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np
from pydrake.geometry import GeometryId, QueryObject
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram, RobotDiagramBuilder
from pydrake.systems.framework import Context

from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.config.visibility_config import VisibilityConfig
from pbpf_drake.poses import quaternions
from pbpf_drake.process_crew import Crew
from pbpf_drake.scene.scene_models import AddSceneModels
from pbpf_drake.shapes.surface_sampling import BodySurface
from pbpf_drake.visibility.ray_casting import CastRays, OccluderSet, RayBody
from pbpf_drake.visibility.ray_culling import coordinates, near_cones


def visibility_log_factor(
    visibility: np.ndarray, *, detected: bool, config: VisibilityConfig
) -> np.ndarray:
    """Returns by what visibility changes the particles' log weights, (M,).

    Without a detection it is log W_H where v < V_H, and log W_L elsewhere:
    the paper leaves v = V_H open, here it counts as visible. With a detection
    it is log alpha_W where v < V_L, and 0 elsewhere.

    Args:
        visibility: the scores v, (M,), in [0, 1].
        detected: whether the object was detected at this step.
        config: the object's thresholds and factors.
    """
    if detected:
        hidden = visibility < config.low_visibility
        return np.where(hidden, np.log(config.penalty), 0.0)
    hidden = visibility < config.high_visibility
    return np.log(np.where(hidden, config.high_weight, config.low_weight))


def in_image(p_CT: np.ndarray, camera: CameraConfig) -> np.ndarray:
    """Returns which points the image has a pixel for, (...).

    The centre of the first pixel is (0, 0), so that the image reaches from
    -0.5 to width - 0.5 and height - 0.5, as in ROS, OpenCV and Drake.

    Args:
        p_CT: points in the camera's optical frame (in meters), (..., 3).
        camera: the camera's intrinsics.
    """
    ahead = p_CT[..., 2] > 0
    z = np.where(ahead, p_CT[..., 2], 1.0)
    u = camera.cx + 0.5 + camera.fx * p_CT[..., 0] / z
    v = camera.cy + 0.5 + camera.fy * p_CT[..., 1] / z
    return (
        ahead & (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    )


class VisibilityModel:
    """Scores how much of each object of each particle the camera sees.

    The score v is the share of R rays that hit the particle. The rays go from
    the camera's centre to points spread over the object's surface, the same
    points for all particles. A ray hits the particle unless it first enters
    the robot, a fixed model, or another tracked object of the same particle.
    The object does not hide its own back: a ray to a point there hits the
    object at its front. A target outside the image is not hit.

    The model never changes. Whoever shares it needs a scratch of their own.
    """

    def __init__(self, *, scene: Scene, num_rays: int):
        """Builds the world of a scene.

        Args:
            scene: the scene; its filter's config is not used.
            num_rays: R, the rays per object and particle.

        Raises:
            ValueError: the scene's models don't fit their roles, a tracked
                object has no collision geometry, or the camera is inside a
                fixed model, which hides everything.
        """
        self._camera = scene.camera
        self._X_CW = scene.camera.pose().inverse()
        self._origin = np.array(scene.camera.pose().translation())
        self._num_rays = num_rays
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

    def MakeScratch(self, parallelism: int = 1) -> Crew:
        """Returns who computes Score, and in what.

        Args:
            parallelism: so many processes share the particles.
        """
        return Crew(_RayCaster(self), parallelism)

    def Score(
        self,
        *,
        particles: np.ndarray,
        active: np.ndarray,
        robot_positions: np.ndarray,
        rng: np.random.Generator,
        scratch: Crew,
    ) -> np.ndarray:
        """Returns the visibility v of every object of every particle.

        Args:
            particles: (M, K, 7 or more), poses X_WO of the objects in the
                scene's order: qw qx qy qz (of unit length), x y z (in
                meters); what follows is not used.
            active: (K,), which objects are tracked yet. The others hide
                nothing, and their score is 1.
            robot_positions: (n,), the robot's joint positions.
            rng: draws the points on the surfaces.
            scratch: from MakeScratch; what is in it does not matter.

        Returns:
            (M, K), in [0, 1].
        """
        tracked = np.flatnonzero(active)
        p_OT = np.stack([s.sample(rng, self._num_rays) for s in self._surfaces])
        shares = np.array_split(particles[:, tracked], scratch.size)
        arguments = {
            "tracked": tracked,
            "p_OT": p_OT[tracked],
            "robot_positions": robot_positions,
        }
        results = scratch.Run(
            _RayCaster.Score,
            [
                [{"particles": share, **arguments}] if len(share) else []
                for share in shares
            ],
        )
        scores = np.ones((len(particles), len(active)))
        scores[:, tracked] = np.concatenate(sum(results, []))
        return scores

    def ScoreParticles(
        self,
        particles: np.ndarray,
        *,
        tracked: np.ndarray,
        p_OT: np.ndarray,
        robot_positions: np.ndarray,
        context: Context,
    ) -> np.ndarray:
        """Returns the share of points that the camera sees, (m, T).

        Args:
            particles: (m, T, 7 or more), as in Score, of the tracked objects.
            tracked: (T,) indices of these objects.
            p_OT: (T, R, 3) points on their surfaces (in meters).
            robot_positions: (n,), the robot's joint positions.
            context: from MakeContext; what is in it does not matter.
        """
        p_WT = particles[:, :, None, 4:7] + quaternions.rotate(
            particles[:, :, None, :4], p_OT
        )
        hit = in_image(self._InCamera(p_WT), self._camera)
        hit &= self._Reached(particles, tracked, p_WT, robot_positions, context)
        return np.mean(hit, axis=-1)

    def MakeContext(self) -> Context:
        """Returns what ScoreParticles computes in."""
        return self._diagram.CreateDefaultContext()

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
        near = near_cones(
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

    def _InCamera(self, p_WT: np.ndarray) -> np.ndarray:
        R_CW = self._X_CW.rotation().matrix()
        return p_WT @ R_CW.T + self._X_CW.translation()

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
                "geometry, so no visibility; expected at least one"
            )
        shapes = [self._inspector.GetShape(g) for g in geometries]
        X_BG = [self._inspector.GetPoseInFrame(g) for g in geometries]
        self._bodies.append(RayBody(shapes=shapes, X_BG=X_BG))
        self._surfaces.append(BodySurface(shapes=shapes, X_BG=X_BG))


class _RayCaster:
    """A context of a visibility model, for one process."""

    def __init__(self, model: VisibilityModel) -> None:
        self._model = model
        self._context = model.MakeContext()

    def Score(self, **arguments: Any) -> np.ndarray:
        """Returns VisibilityModel.ScoreParticles of these arguments."""
        return self._model.ScoreParticles(**arguments, context=self._context)
