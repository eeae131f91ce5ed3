"""The model in which particles are predicted, f_θ of Section 4.1.

It holds the robot, the fixed models and the tracked objects of a scene in one
RobotDiagram, with contact geometry that stays on the table and a robot that
follows its measured motion. All particles share it; each has a context.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraphInspector,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram, RobotDiagramBuilder

from pbpf_drake.contact_points import MakeContactPoints, MakeCore
from pbpf_drake.prescribed_robot import (
    FreeRobotJoints,
    MakeRobotCoast,
    RobotJointNames,
)
from pbpf_drake.scene import Scene
from pbpf_drake.scene_models import AddSceneModels, SceneModels

# Of an object's contacts (in N/m): a 1 kg block on four points sinks 0.08 mm.
_STIFFNESS = 3e4
# Everything else is so stiff and rough that only the object's own stiffness,
# dissipation and friction count in a contact; see SetPhysicalParameters.
_RIGID = 1e9
_ROUGH = 1e9


@dataclass(frozen=True)
class PredictionModel:
    """A finalized prediction model and where things are in it.

    Attributes:
        diagram: shared by all particles, never changed.
        models: the roles of its bodies.
        joint_names: n, the robot's joints in the order of q.
        robot_q, robot_v: (n,) indices into the plant's q and v.
        object_q: (K, 7) indices into q: qw qx qy qz, x y z.
        object_v: (K, 6) indices into v: angular, then translational.
        object_geometries: the geometry ids of each object.
        fixed_geometries: those of the fixed models.
        nominal_poses: (K, 7) the scene's own poses of the objects.
    """

    diagram: RobotDiagram
    models: SceneModels
    joint_names: tuple[str, ...]
    robot_q: np.ndarray
    robot_v: np.ndarray
    object_q: np.ndarray
    object_v: np.ndarray
    object_geometries: tuple[frozenset[GeometryId], ...]
    fixed_geometries: frozenset[GeometryId]
    nominal_poses: np.ndarray

    def owner(self, geometry: GeometryId) -> int | None:
        """Returns which tracked object a geometry is part of, if any."""
        for k, geometries in enumerate(self.object_geometries):
            if geometry in geometries:
                return k
        return None


def MakePredictionModel(scene: Scene) -> PredictionModel:
    """Builds the prediction model of a scene.

    Raises:
        ValueError: the scene's models don't fit their roles.
    """
    builder = RobotDiagramBuilder(time_step=0.0)
    plant = builder.plant()
    models = AddSceneModels(plant, scene)
    FreeRobotJoints(plant, models.robot)
    _ContactGeometry(builder, models).Build()
    plant.Finalize()
    try:
        joint_names = tuple(RobotJointNames(plant, models.robot))
    except ValueError as error:
        raise ValueError(f"Scene {scene.path}: robot: {error}") from error
    MakeRobotCoast(plant, models.robot)
    diagram = builder.Build()
    plant = diagram.plant()
    bodies = [plant.get_body(b) for b in models.objects]
    context = plant.CreateDefaultContext()
    robot_q = np.arange(plant.num_positions())
    robot_q = plant.GetPositionsFromArray(models.robot, robot_q).astype(int)
    robot_v = np.arange(plant.num_velocities())
    robot_v = plant.GetVelocitiesFromArray(models.robot, robot_v).astype(int)
    object_q = np.array(
        [np.arange(7) + b.floating_positions_start() for b in bodies]
    )
    object_v = np.array(
        [np.arange(6) + b.floating_velocities_start_in_v() for b in bodies]
    )
    return PredictionModel(
        diagram=diagram,
        models=models,
        joint_names=joint_names,
        robot_q=robot_q,
        robot_v=robot_v,
        object_q=object_q,
        object_v=object_v,
        object_geometries=tuple(
            frozenset(plant.GetCollisionGeometriesForBody(b)) for b in bodies
        ),
        fixed_geometries=frozenset(
            geometry
            for b in models.fixed
            for geometry in plant.GetCollisionGeometriesForBody(
                plant.get_body(b)
            )
        ),
        nominal_poses=plant.GetPositions(context)[object_q],
    )


class _ContactGeometry:
    """Gives the tracked and fixed bodies their points and cores.

    Of a tracked object, the robot touches the whole shape, and the fixed
    models touch its points and its core. Two objects touch with the points of
    one and the whole shape of the other, or with their cores.
    """

    def __init__(self, builder: RobotDiagramBuilder, models: SceneModels):
        self._plant = builder.plant()
        self._scene_graph = builder.scene_graph()
        self._models = models
        self._robot = GeometrySet()
        self._fixed = GeometrySet()
        self._fixed_points = GeometrySet()
        self._whole = GeometrySet()
        self._cores = GeometrySet()
        self._points = GeometrySet()

    def Build(self) -> None:
        plant = self._plant
        for index in plant.GetBodyIndices(self._models.robot):
            for geometry in self._MakeRigid(index):
                self._robot.Add(geometry)
        for index in self._models.fixed:
            for geometry in self._MakeRigid(index):
                self._fixed.Add(geometry)
                self._AddPoints(index, geometry, self._fixed_points, _RIGID)
        for index in self._models.objects:
            self._AddObject(index)
        self._Filter()

    def _AddObject(self, index: BodyIndex) -> None:
        body = self._plant.get_body(index)
        for geometry in self._Geometries(index):
            self._SetMaterial(geometry, _STIFFNESS)
            shape = self._Inspector().GetShape(geometry)
            core = MakeCore(shape)
            self._AddPoints(index, geometry, self._points, _STIFFNESS)
            if core is None:
                # Round all over, or a hull: everything touches the whole.
                continue
            self._whole.Add(geometry)
            self._cores.Add(
                self._plant.RegisterCollisionGeometry(
                    body,
                    self._Inspector().GetPoseInFrame(geometry),
                    core,
                    f"{self._Name(geometry)}_core",
                    _material(_STIFFNESS),
                )
            )

    def _AddPoints(
        self,
        index: BodyIndex,
        geometry: GeometryId,
        group: GeometrySet,
        stiffness: float,
    ) -> None:
        inspector = self._Inspector()
        X_BG = inspector.GetPoseInFrame(geometry)
        points = MakeContactPoints(inspector.GetShape(geometry))
        for i, p_GS in enumerate(points.p_GS):
            group.Add(
                self._plant.RegisterCollisionGeometry(
                    self._plant.get_body(index),
                    X_BG @ RigidTransform(p_GS),
                    Sphere(points.radius),
                    f"{self._Name(geometry)}_point_{i}",
                    _material(stiffness),
                )
            )

    def _Filter(self) -> None:
        filters = CollisionFilterDeclaration()
        filters.ExcludeWithin(self._robot)
        filters.ExcludeBetween(self._robot, self._fixed)
        filters.ExcludeBetween(self._robot, self._fixed_points)
        filters.ExcludeBetween(self._robot, self._points)
        filters.ExcludeBetween(self._robot, self._cores)
        filters.ExcludeWithin(self._points)
        filters.ExcludeWithin(self._whole)
        filters.ExcludeBetween(self._whole, self._fixed)
        filters.ExcludeBetween(self._whole, self._cores)
        filters.ExcludeBetween(self._points, self._cores)
        filters.ExcludeBetween(self._points, self._fixed_points)
        self._scene_graph.collision_filter_manager().Apply(filters)

    def _Inspector(self) -> SceneGraphInspector:
        return self._scene_graph.model_inspector()

    def _Name(self, geometry: GeometryId) -> str:
        return self._Inspector().GetName(geometry).split("::")[-1]

    def _Geometries(self, index: BodyIndex) -> list[GeometryId]:
        # Not the plant's own list: it moves when geometry is registered.
        frame = self._plant.GetBodyFrameIdOrThrow(index)
        return self._Inspector().GetGeometries(frame, Role.kProximity)

    def _MakeRigid(self, index: BodyIndex) -> list[GeometryId]:
        geometries = self._Geometries(index)
        for geometry in geometries:
            self._SetMaterial(geometry, _RIGID)
        return geometries

    def _SetMaterial(self, geometry: GeometryId, stiffness: float) -> None:
        source = self._plant.get_source_id()
        self._scene_graph.AssignRole(
            source, geometry, _material(stiffness), RoleAssign.kReplace
        )


def _material(stiffness: float) -> ProximityProperties:
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=0.0,
        point_stiffness=stiffness,
        friction=CoulombFriction(_ROUGH, _ROUGH),
        properties=properties,
    )
    return properties
