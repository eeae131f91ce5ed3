"""The diagram of the truth; it is not the filter's prediction model.

Hydroelastic contact, a fine fixed step, friction and masses of its own, and a
robot that a joint controller moves and that contact can push back.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Capsule,
    Cylinder,
    Ellipsoid,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import (
    ContactModel,
    CoulombFriction,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.multibody.tree import (
    BodyIndex,
    JointIndex,
    ModelInstanceIndex,
    PdControllerGains,
)
from pydrake.planning import RobotDiagram, RobotDiagramBuilder
from pydrake.systems.framework import Context
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from pbpf_drake.config.recording_config import RecordingConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.scene.object_size import CheckObjectSizes
from pbpf_drake.scene.scene_models import AddSceneModels, SceneModels
from pbpf_drake.truth.path_collision import CheckPath
from pbpf_drake.truth.push_path import (
    ActuatedJoints,
    MakeJointTrajectory,
    MakeTranslation,
    draw_offsets,
)
from pbpf_drake.truth.simulated_detector import AddLabelRenderer


@dataclass(frozen=True)
class TruthParameters:
    """What is drawn once per run.

    Attributes:
        mass_scale: (K,) true masses of the objects over their models'.
        friction: between objects and everything fixed.
        robot_friction: of the robot's surface.
        offsets: (W, 3) errors of the path's waypoints (in meters).
        starts: (K, 3) by how much the objects start from elsewhere: x and y
            (in meters), then the angle about the vertical (in radians).
    """

    mass_scale: np.ndarray
    friction: float
    robot_friction: float
    offsets: np.ndarray
    starts: np.ndarray


def draw_truth_parameters(
    config: RecordingConfig, num_objects: int, rng: np.random.Generator
) -> TruthParameters:
    """Draws the true parameters of a run."""
    stddev = config.start_stddev
    return TruthParameters(
        mass_scale=rng.uniform(
            config.mass_scale.min, config.mass_scale.max, num_objects
        ),
        friction=rng.uniform(config.friction.min, config.friction.max),
        robot_friction=rng.uniform(
            config.robot_friction.min, config.robot_friction.max
        ),
        offsets=draw_offsets(config.path, rng),
        starts=rng.standard_normal((num_objects, 3))
        * [stddev.position, stddev.position, stddev.rotation],
    )


@dataclass(frozen=True)
class Truth:
    """The diagram and who is who in it.

    Attributes:
        diagram: plant, scene graph, controller and path.
        models: the roles of the scene's models.
        joints: the robot's joints, in the order of its actuators.
        trajectory: their commanded positions over time.
    """

    diagram: RobotDiagram
    models: SceneModels
    joints: Sequence[JointIndex]
    trajectory: PiecewisePolynomial


def AddTruthModels(
    *,
    builder: RobotDiagramBuilder,
    scene: Scene,
    parameters: TruthParameters,
) -> SceneModels:
    """Adds the scene's models to a plant, with contact as it truly is.

    The plant is finalized. Its input for the robot's desired state, joints in
    the order of the actuators, is left to connect.

    Args:
        builder: its plant is discrete, and empty.
        scene: the scene; its ``recording`` says how contact and control are.
        parameters: of this run.

    Raises:
        ValueError: the scene's ``recording`` doesn't fit its models.
    """
    plant, scene_graph = builder.plant(), builder.scene_graph()
    plant.set_contact_model(ContactModel.kHydroelasticWithFallback)
    plant.set_discrete_contact_approximation(
        DiscreteContactApproximation.kLagged
    )
    models = AddSceneModels(plant, scene)
    CheckObjectSizes(
        scene=scene,
        inspector=scene_graph.model_inspector(),
        geometries=[
            plant.GetCollisionGeometriesForBody(plant.get_body(b))
            for b in models.objects
        ],
    )
    _set_contact(plant, scene_graph, models, scene.recording, parameters)
    _set_controller(plant, models.robot, scene.recording)
    AddLabelRenderer(scene_graph)
    plant.Finalize()
    return models


def SetTrueObjects(
    *,
    plant: MultibodyPlant,
    context: Context,
    models: SceneModels,
    parameters: TruthParameters,
) -> None:
    """Writes the objects' true masses and starts into the plant's context."""
    for index, scale, start in zip(
        models.objects,
        parameters.mass_scale,
        parameters.starts,
        strict=True,
    ):
        body = plant.get_body(index)
        body.SetMass(context, body.default_mass() * scale)
        X_WO = move_start(body.EvalPoseInWorld(context), start)
        plant.SetFreeBodyPose(context, body, X_WO)


def MakeTruth(*, scene: Scene, parameters: TruthParameters) -> Truth:
    """Builds the truth of a scene.

    Raises:
        ValueError: the scene's ``recording`` doesn't fit its models, or the
            robot can't follow the path.
    """
    config = scene.recording
    builder = RobotDiagramBuilder(time_step=config.time_step)
    models = AddTruthModels(builder=builder, scene=scene, parameters=parameters)
    plant = builder.plant()
    joints = ActuatedJoints(plant, models.robot)
    trajectory = MakeJointTrajectory(
        plant=plant,
        robot=models.robot,
        end_effector=config.path.end_effector,
        translation=MakeTranslation(config.path, parameters.offsets),
    )
    commands = builder.builder().AddNamedSystem(
        name="path",
        system=TrajectorySource(
            trajectory=trajectory,
            output_derivative_order=1,
            zero_derivatives_beyond_limits=True,
        ),
    )
    builder.builder().Connect(
        commands.get_output_port(),
        plant.get_desired_state_input_port(models.robot),
    )
    return Truth(builder.Build(), models, joints, trajectory)


def MakeTruthContext(*, truth: Truth, parameters: TruthParameters) -> Context:
    """Returns the state at the start, with the true masses and poses.

    Raises:
        ValueError: the path leads into something fixed.
    """
    diagram = truth.diagram
    context = diagram.CreateDefaultContext()
    SetTrueObjects(
        plant=diagram.plant(),
        context=diagram.mutable_plant_context(context),
        models=truth.models,
        parameters=parameters,
    )
    CheckPath(
        diagram=diagram,
        models=truth.models,
        joints=truth.joints,
        trajectory=truth.trajectory,
    )
    return context


def move_start(X_WO: RigidTransform, start: np.ndarray) -> RigidTransform:
    """Returns a pose shifted along the table and turned on it.

    Args:
        X_WO: a pose.
        start: x and y (in meters), then an angle (in radians) about the
            vertical through the object's origin.
    """
    return RigidTransform(
        RotationMatrix.MakeZRotation(start[2]) @ X_WO.rotation(),
        X_WO.translation() + [start[0], start[1], 0.0],
    )


def _set_contact(
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    models: SceneModels,
    config: RecordingConfig,
    parameters: TruthParameters,
) -> None:
    """Replaces what the models' files say of contact by the truth's own."""
    inspector = scene_graph.model_inspector()
    for i in range(plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        is_robot = body.model_instance() == models.robot
        mu = parameters.robot_friction if is_robot else parameters.friction
        for geometry in plant.GetCollisionGeometriesForBody(body):
            properties = ProximityProperties()
            length = config.mesh_resolution * _radius(
                inspector.GetShape(geometry)
            )
            if body.index() in models.objects:
                AddCompliantHydroelasticProperties(
                    length, config.hydroelastic_modulus, properties
                )
            else:
                AddRigidHydroelasticProperties(length, properties)
            AddContactMaterial(
                dissipation=config.dissipation,
                friction=CoulombFriction(mu, mu),
                properties=properties,
            )
            scene_graph.AssignRole(
                plant.get_source_id(), geometry, properties, RoleAssign.kReplace
            )


def _radius(shape: Shape) -> float:
    """Returns the radius of a round shape, and 1 for shapes without one.

    Only the meshes of round shapes depend on the length derived from it.
    """
    if isinstance(shape, Sphere | Cylinder | Capsule):
        return shape.radius()
    if isinstance(shape, Ellipsoid):
        return min(shape.a(), shape.b(), shape.c())
    return 1.0


def _set_controller(
    plant: MultibodyPlant, robot: ModelInstanceIndex, config: RecordingConfig
) -> None:
    # Before Finalize, only the list of all actuators is complete.
    actuators = [
        plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()
    ]
    actuators = [a for a in actuators if a.model_instance() == robot]
    for name in ("stiffness", "damping"):
        if len(getattr(config, name)) != len(actuators):
            raise ValueError(
                f"recording.{name} has {len(getattr(config, name))} numbers; "
                f"expected one for each of the robot's {len(actuators)} "
                "actuators"
            )
    for actuator, p, d in zip(
        actuators, config.stiffness, config.damping, strict=True
    ):
        actuator.set_controller_gains(PdControllerGains(p=p, d=d))
    plant.set_gravity_enabled(robot, False)
