"""The plant in which each particle is simulated.

It holds the objects, the fixed models and some links of the robot. All
particles share it, and each has a context of its own. Its contact geometry is
made so that things stay on the table. The links are free bodies that are too
heavy for a contact to change how they move: q(t) = q₀ + v t.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
import itertools

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    CollisionFilterDeclaration,
    GeometryId,
    GeometrySet,
    ProximityProperties,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ContactModel, CoulombFriction
from pydrake.multibody.tree import (
    BodyIndex,
    ModelInstanceIndex,
    RigidBody,
    SpatialInertia,
    UnitInertia,
    default_model_instance,
)
from pydrake.planning import RobotDiagram, RobotDiagramBuilder
from pydrake.systems.framework import Context

from pbpf_drake.motion.robot_links import LinkSet
from pbpf_drake.scene.prediction_model import PredictionModel
from pbpf_drake.shapes.contact_points import MakeContactPoints, MakeCore

# The mass of each link (in kg); in kg m² it is also its rotational inertia. A
# force of 100 N for 0.16 s changes a link's speed by 2e-4 m/s at most.
_LINK_MASS = 1e5
# Everything but the objects is so stiff and so rough that in a contact only the
# object's own stiffness, dissipation and friction count.
_RIGID = 1e9
_ROUGH = 1e9


@dataclass(frozen=True)
class ParticlePlant:
    """The plant in which each particle is simulated, and what is where in it.

    Attributes:
        diagram: the plant and its scene graph, finalized. All particles share
            it, and nobody changes it.
        link_set: which of the robot's links it has.
        link_q: (L, 7) indices into the plant's q: qw qx qy qz, x y z.
        link_v: (L, 6) indices into its v: angular, then translational.
        object_q: (K, 7) indices into q: qw qx qy qz, x y z.
        object_v: (K, 6) indices into v: angular, then translational.
        objects: the bodies of the K objects.
        owners: of each geometry of an object, the object's index k.
        points: the geometries of the objects that are contact points.
        link_geometries: the geometries of the links.
        fixed_geometries: the geometries of the fixed models.
    """

    diagram: RobotDiagram
    link_set: LinkSet
    link_q: np.ndarray
    link_v: np.ndarray
    object_q: np.ndarray
    object_v: np.ndarray
    objects: tuple[BodyIndex, ...]
    owners: dict[GeometryId, int]
    points: frozenset[GeometryId]
    link_geometries: frozenset[GeometryId]
    fixed_geometries: frozenset[GeometryId]


def MakeParticlePlant(
    model: PredictionModel, link_set: Sequence[int]
) -> ParticlePlant:
    """Returns the plant of a scene, with some of the robot's links.

    Args:
        model: the scene's models.
        link_set: the links, indices into the model's.
    """
    return _Builder(model, tuple(link_set)).Build()


class _Builder:
    """Copies the scene's bodies, and adds points and cores to their shapes.

    The robot touches the whole shape of an object. Fixed models touch the
    points and the core of an object. Two objects touch with the points of one
    and the whole shape of the other, or with both cores.
    """

    def __init__(self, model: PredictionModel, link_set: LinkSet):
        self._model = model
        self._link_set = link_set
        self._source = model.diagram.plant()
        self._inspector = model.diagram.scene_graph().model_inspector()
        self._builder = RobotDiagramBuilder(time_step=0.0)
        self._plant = self._builder.plant()
        self._plant.set_contact_model(ContactModel.kPoint)
        self._robot = GeometrySet()
        self._fixed = GeometrySet()
        self._fixed_points = GeometrySet()
        self._whole = GeometrySet()
        self._cores = GeometrySet()
        self._points = GeometrySet()
        self._point_ids: list[GeometryId] = []
        # The geometries here that stand for each geometry of the scene.
        self._copies: dict[GeometryId, list[GeometryId]] = {}

    def Build(self) -> ParticlePlant:
        robot = self._plant.AddModelInstance("robot")
        self._plant.set_gravity_enabled(robot, False)
        context = self._source.CreateDefaultContext()
        for index in self._model.models.fixed:
            self._AddFixed(index, context)
        links = [
            self._AddLink(robot, self._model.links[i]) for i in self._link_set
        ]
        objects = [self._AddObject(i) for i in self._model.models.objects]
        self._Filter()
        self._plant.Finalize()
        return ParticlePlant(
            diagram=self._builder.Build(),
            link_set=self._link_set,
            link_q=_rows(links, 7, RigidBody.floating_positions_start),
            link_v=_rows(links, 6, RigidBody.floating_velocities_start_in_v),
            object_q=_rows(objects, 7, RigidBody.floating_positions_start),
            object_v=_rows(
                objects, 6, RigidBody.floating_velocities_start_in_v
            ),
            objects=tuple(body.index() for body in objects),
            owners={
                copy: k
                for k, index in enumerate(self._model.models.objects)
                for copy in self._CopiesOf([index])
            },
            points=frozenset(self._point_ids),
            link_geometries=frozenset(
                self._CopiesOf(self._model.links[i] for i in self._link_set)
            ),
            fixed_geometries=frozenset(
                self._CopiesOf(self._model.models.fixed)
            ),
        )

    def _AddFixed(self, index: BodyIndex, context: Context) -> None:
        X_WB = self._source.get_body(index).EvalPoseInWorld(context)
        world = self._plant.world_body()
        for geometry in self._model.geometries(index):
            self._fixed.Add(self._AddWhole(world, geometry, X_WB))
            self._fixed_points.Add(self._AddPoints(world, geometry, X_WB))

    def _AddLink(
        self, robot: ModelInstanceIndex, index: BodyIndex
    ) -> RigidBody:
        inertia = SpatialInertia(_LINK_MASS, np.zeros(3), UnitInertia(1, 1, 1))
        link = self._plant.AddRigidBody(f"link_{int(index)}", robot, inertia)
        for geometry in self._model.geometries(index):
            self._robot.Add(self._AddWhole(link, geometry))
        return link

    def _AddObject(self, index: BodyIndex) -> RigidBody:
        inertia = self._source.get_body(index).default_spatial_inertia()
        body = self._plant.AddRigidBody(
            f"object_{int(index)}", default_model_instance(), inertia
        )
        for geometry in self._model.geometries(index):
            whole = self._AddWhole(body, geometry)
            points = self._AddPoints(body, geometry)
            self._points.Add(points)
            self._point_ids += points
            core = MakeCore(self._inspector.GetShape(geometry))
            # What is round all over, or a hull, has no core, and everything
            # touches its whole shape.
            if core is not None:
                self._whole.Add(whole)
                self._cores.Add(self._AddShape(body, geometry, core))
        return body

    def _AddWhole(
        self,
        body: RigidBody,
        geometry: GeometryId,
        X_BS: RigidTransform | None = None,
    ) -> GeometryId:
        shape = self._inspector.GetShape(geometry)
        return self._AddShape(body, geometry, shape, X_BS)

    def _AddPoints(
        self,
        body: RigidBody,
        geometry: GeometryId,
        X_BS: RigidTransform | None = None,
    ) -> list[GeometryId]:
        points = MakeContactPoints(self._inspector.GetShape(geometry))
        sphere = Sphere(points.radius)
        return [
            self._AddShape(body, geometry, sphere, X_BS, RigidTransform(p))
            for p in points.p_GS
        ]

    def _AddShape(
        self,
        body: RigidBody,
        geometry: GeometryId,
        shape: Shape,
        X_BS: RigidTransform | None = None,
        X_GP: RigidTransform | None = None,
    ) -> GeometryId:
        """Adds a shape to a body B of the plant, and returns its geometry.

        Args:
            body: B, which stands for a body S of the scene.
            geometry: a geometry G of S, which the shape stands for.
            shape: what to add.
            X_BS: the pose of S in B; None where they are the same.
            X_GP: the pose of the shape in G; None where they are the same.
        """
        copies = self._copies.setdefault(geometry, [])
        X_SG = self._inspector.GetPoseInFrame(geometry)
        X_BG = X_BS @ X_SG if X_BS is not None else X_SG
        copies.append(
            self._plant.RegisterCollisionGeometry(
                body,
                X_BG @ X_GP if X_GP is not None else X_BG,
                shape,
                f"{geometry.get_value()}_{len(copies)}",
                _Material(),
            )
        )
        return copies[-1]

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
        # The scene's own filters hold for the copies, too.
        for a, b in itertools.combinations(self._copies, 2):
            if self._inspector.CollisionFiltered(a, b):
                filters.ExcludeBetween(
                    GeometrySet(self._copies[a]), GeometrySet(self._copies[b])
                )
        scene_graph = self._builder.scene_graph()
        scene_graph.collision_filter_manager().Apply(filters)

    def _CopiesOf(self, bodies: Iterable[BodyIndex]) -> list[GeometryId]:
        return [
            copy
            for index in bodies
            for geometry in self._model.geometries(index)
            for copy in self._copies[geometry]
        ]


def _rows(
    bodies: Sequence[RigidBody], count: int, start: Callable[[RigidBody], int]
) -> np.ndarray:
    starts = np.array([start(body) for body in bodies], dtype=int)
    return starts[:, None] + np.arange(count)


def _Material() -> ProximityProperties:
    """Returns what everything is made of until SetPhysicalParameters.

    In each context, that gives the objects a material of their own.
    """
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=0.0,
        point_stiffness=_RIGID,
        friction=CoulombFriction(_ROUGH, _ROUGH),
        properties=properties,
    )
    return properties
