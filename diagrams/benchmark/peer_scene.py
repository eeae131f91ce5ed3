"""A scene as other physics engines need it, read from Drake's own model.

Shapes, poses, masses and kinematics are those that Drake has parsed from the
scene's files, whatever their format.
"""

from dataclasses import dataclass, replace

import numpy as np
from pydrake.geometry import Box, Capsule, Cylinder, Shape, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.tree import (
    BodyIndex,
    Joint,
    JointIndex,
    PrismaticJoint,
    world_index,
)
from pydrake.planning import RobotDiagram, RobotDiagramBuilder
from pydrake.systems.framework import Context

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.scene.scene_models import AddSceneModels


@dataclass(frozen=True)
class PeerShape:
    """A collision shape.

    Attributes:
        kind: "box", "cylinder", "capsule" or "sphere"; the axis of the middle
            two is z.
        size: of a box its three sides; else the radius and, unless it is a
            sphere, the length, without a capsule's ends (in meters).
        X_BG: its pose in its body; in the world if it is fixed.
    """

    kind: str
    size: tuple[float, ...]
    X_BG: RigidTransform


@dataclass(frozen=True)
class PeerObject:
    """A tracked object; its centre of mass is taken to be its origin.

    Attributes:
        name: of its model.
        shapes: its collision shapes.
        mass: in kilograms.
        inertia: (3, 3) about its origin (in kg m²).
    """

    name: str
    shapes: tuple[PeerShape, ...]
    mass: float
    inertia: np.ndarray


@dataclass(frozen=True)
class PeerLink:
    """A link of the robot.

    Attributes:
        name: of its body.
        shapes: its collision shapes.
        parent: name of the link that it hangs on; "" is the world.
        X_PB: its pose in the parent where all joints are 0.
        joint: name of the joint that it moves with, or "".
        slides: whether that is a prismatic joint.
        axis: (3,) of the joint, in the link.
        p_BJ: (3,) a point on that axis, in the link (in meters).
    """

    name: str
    shapes: tuple[PeerShape, ...]
    parent: str
    X_PB: RigidTransform
    joint: str
    slides: bool
    axis: np.ndarray
    p_BJ: np.ndarray


@dataclass(frozen=True)
class PeerScene:
    """Everything that has a shape.

    Attributes:
        objects: the K tracked objects.
        fixed: the shapes of all that is fixed.
        links: the robot's links.
    """

    objects: tuple[PeerObject, ...]
    fixed: tuple[PeerShape, ...]
    links: tuple[PeerLink, ...]


def ReadPeerScene(scene: Scene) -> PeerScene:
    """Reads a scene.

    Raises:
        ValueError: a shape is of another kind than those of PeerShape.
    """
    builder = RobotDiagramBuilder(time_step=0.0)
    models = AddSceneModels(builder.plant(), scene)
    diagram = builder.Build()
    plant = diagram.plant()
    context = plant.CreateDefaultContext()
    plant.SetPositions(
        context, models.robot, np.zeros(plant.num_positions(models.robot))
    )
    return PeerScene(
        objects=tuple(_read_object(diagram, b) for b in models.objects),
        fixed=tuple(
            _in_world(shape, plant.get_body(b).EvalPoseInWorld(context))
            for b in models.fixed
            for shape in _read_shapes(diagram, b)
        ),
        links=tuple(
            _read_link(diagram, context, plant.get_joint(JointIndex(i)))
            for i in plant.GetJointIndices(models.robot)
        ),
    )


def _in_world(shape: PeerShape, X_WB: RigidTransform) -> PeerShape:
    return replace(shape, X_BG=X_WB @ shape.X_BG)


def _read_object(diagram: RobotDiagram, index: BodyIndex) -> PeerObject:
    body = diagram.plant().get_body(index)
    inertia = body.default_spatial_inertia().CalcRotationalInertia()
    return PeerObject(
        name=body.name(),
        shapes=_read_shapes(diagram, index),
        mass=body.default_mass(),
        inertia=inertia.CopyToFullMatrix3(),
    )


def _read_shapes(
    diagram: RobotDiagram, index: BodyIndex
) -> tuple[PeerShape, ...]:
    plant = diagram.plant()
    inspector = diagram.scene_graph().model_inspector()
    shapes = []
    for g in plant.GetCollisionGeometriesForBody(plant.get_body(index)):
        kind, size = describe_shape(inspector.GetShape(g), inspector.GetName(g))
        shapes.append(PeerShape(kind, size, inspector.GetPoseInFrame(g)))
    return tuple(shapes)


def describe_shape(shape: Shape, name: str) -> tuple[str, tuple[float, ...]]:
    """Returns kind and size of a shape; see PeerShape."""
    if isinstance(shape, Box):
        return "box", tuple(shape.size())
    if isinstance(shape, Cylinder):
        return "cylinder", (shape.radius(), shape.length())
    if isinstance(shape, Capsule):
        return "capsule", (shape.radius(), shape.length())
    if isinstance(shape, Sphere):
        return "sphere", (shape.radius(),)
    raise ValueError(
        f"geometry {name!r} is a {type(shape).__name__}; for the other "
        "engines expected a Box, a Cylinder, a Capsule or a Sphere"
    )


def _read_link(
    diagram: RobotDiagram, context: Context, joint: Joint
) -> PeerLink:
    """Returns the link that a joint or weld moves."""
    plant = diagram.plant()
    body, parent = joint.child_body(), joint.parent_body()
    X_WP = plant.EvalBodyPoseInWorld(context, parent)
    X_BJ = joint.frame_on_child().GetFixedPoseInBodyFrame()
    axis = np.zeros(3)
    slides = isinstance(joint, PrismaticJoint)
    if slides:
        axis = joint.translation_axis()
    elif joint.num_positions() > 0:
        axis = joint.revolute_axis()
    return PeerLink(
        name=body.name(),
        shapes=_read_shapes(diagram, body.index()),
        parent="" if parent.index() == world_index() else parent.name(),
        X_PB=X_WP.inverse() @ plant.EvalBodyPoseInWorld(context, body),
        joint=joint.name() if joint.num_positions() > 0 else "",
        slides=slides,
        axis=X_BJ.rotation() @ axis,
        p_BJ=X_BJ.translation(),
    )
