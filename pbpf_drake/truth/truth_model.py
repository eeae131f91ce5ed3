"""The diagram that simulates the truth; the filter's physics isn't in it.

Contact is hydroelastic, the time step is fine and fixed, friction and masses
are the truth's own, and the robot is moved by a joint controller, so that
contact can push it back.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import (
    ContactModel,
    DiscreteContactApproximation,
    MultibodyPlant,
)
from pydrake.multibody.tree import (
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
    AddMissingActuators,
    MakeJointTrajectory,
    MakeTranslation,
)
from pbpf_drake.truth.true_visibility import AddLabelRenderer
from pbpf_drake.truth.truth_contact import ExcludeSelfContact, SetTrueContact
from pbpf_drake.truth.truth_parameters import TruthParameters


@dataclass(frozen=True)
class Truth:
    """The diagram of the truth, and who is who in it.

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
    """Adds the scene's models to an empty plant, and finalizes it.

    Contact is that of the truth. What is left to connect is the plant's input
    for the robot's desired state, joints in the order of the actuators.

    Args:
        builder: its plant is discrete, and empty.
        scene: its ``recording`` describes contact and the joint controller.
        parameters: those of this run.

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
    SetTrueContact(
        plant=plant,
        scene_graph=scene_graph,
        models=models,
        config=scene.recording,
        parameters=parameters,
    )
    ExcludeSelfContact(plant=plant, scene_graph=scene_graph, models=models)
    AddMissingActuators(plant, models.robot)
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
    """Writes the objects' true masses and poses into the plant's context.

    Args:
        plant: finalized.
        context: the plant's, with the scene's own poses.
        models: who is who in the plant.
        parameters: those of this run.
    """
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


def _set_controller(
    plant: MultibodyPlant, robot: ModelInstanceIndex, config: RecordingConfig
) -> None:
    """Sets the gains of the robot's joints, and lifts gravity from it."""
    # The plant isn't finalized: it can't list the robot's own actuators yet.
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
