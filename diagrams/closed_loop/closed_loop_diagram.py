"""The diagram in which a controller pushes an object by an estimate of it.

::

    camera -> estimator -> push controller -> servo -> joint control -> arm
      ^           ^                                                      |
      +-----------+------------------ state of the truth ----------------+

All arrows but the last one start at discrete state, so there is no algebraic
loop. The truth is that of truth_model, not the filter's physics.
"""

from dataclasses import dataclass, replace

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.planning import RobotDiagram, RobotDiagramBuilder
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    OutputPort,
    System,
)
from pydrake.systems.primitives import Demultiplexer

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.connect_ports import ConnectByName
from pbpf_drake.diagrams.closed_loop.cartesian_servo import CartesianServo
from pbpf_drake.diagrams.closed_loop.push_controller import (
    PushController,
    PushControllerConfig,
)
from pbpf_drake.diagrams.closed_loop.push_task import PushTask
from pbpf_drake.diagrams.closed_loop.simulated_camera import SimulatedCamera
from pbpf_drake.diagrams.closed_loop.true_pose_source import TruePoseSource
from pbpf_drake.filtering.add_estimator import AddEstimator
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import SceneModels
from pbpf_drake.tracking.tracking_diagram import DefaultConfig
from pbpf_drake.truth.truth_model import AddTruthModels, SetTrueObjects

# What the controller goes by.
FEEDBACKS = ("pbpf", "pbpf-v", "dope", "truth")
_HAND = "panda_hand"
# The fingertips of the closed gripper in the hand's frame (in meters).
_FINGERTIP = (0.0, 0.0, 0.1124)


@dataclass(frozen=True)
class ClosedLoop:
    """The diagram of one run, and its parts.

    Attributes:
        diagram: the whole.
        context: its state at the start.
        models: who is who in the plant.
        camera: the camera with the detector.
        controller: says where the fingertip has to be.
    """

    diagram: RobotDiagram
    context: Context
    models: SceneModels
    camera: SimulatedCamera
    controller: PushController

    def object_position(self) -> np.ndarray:
        """Returns where the object truly is now, (3,) (in meters)."""
        body = self.diagram.plant().get_body(self.models.objects[0])
        return body.EvalPoseInWorld(
            self.diagram.plant_context(self.context)
        ).translation()


def MakeClosedLoop(
    *, scene: Scene, feedback: str, task: PushTask
) -> ClosedLoop:
    """Builds the diagram.

    Args:
        scene: closed_loop_push.yaml, or one like it.
        feedback: one of FEEDBACKS.
        task: what to do.
    """
    robot_builder = RobotDiagramBuilder(time_step=scene.recording.time_step)
    # The truth: the arm with the control of its joints, and the object.
    models = AddTruthModels(
        builder=robot_builder, scene=scene, parameters=task.parameters
    )
    plant, builder = robot_builder.plant(), robot_builder.builder()
    # A camera that looks at the truth, with a detector.
    camera = _AddCamera(builder, plant, scene, task.seed)
    # What is measured of the truth: what an estimator may listen to.
    sources = {
        **_AddJointSensor(builder, plant, models),
        "dope_measurement": camera.GetOutputPort("dope_measurement"),
        "state": plant.get_state_output_port(),
    }
    # What says where the object is.
    estimator = _AddFeedback(builder, scene, feedback, task.seed)
    ConnectByName(builder=builder, sources=sources, target=estimator)
    # What decides where to push, and what moves the joints accordingly.
    controller = _AddController(builder, plant, models, task.goal)
    builder.Connect(
        estimator.GetOutputPort("estimated_poses"),
        controller.GetInputPort("estimated_poses"),
    )
    # The whole, with the object where the task has it.
    diagram = robot_builder.Build()
    context = diagram.CreateDefaultContext()
    _SetStart(diagram, context, models, task)
    return ClosedLoop(diagram, context, models, camera, controller)


def _AddCamera(
    builder: DiagramBuilder, plant: MultibodyPlant, scene: Scene, seed: int
) -> SimulatedCamera:
    camera = builder.AddNamedSystem(
        "camera",
        SimulatedCamera(
            scene=scene,
            num_states=plant.num_multibody_states(),
            rng=np.random.default_rng([seed, 1]),
        ),
    )
    builder.Connect(plant.get_state_output_port(), camera.GetInputPort("state"))
    return camera


def _AddJointSensor(
    builder: DiagramBuilder, plant: MultibodyPlant, models: SceneModels
) -> dict[str, OutputPort]:
    """Takes the robot's state apart; returns ports by names of inputs."""
    n = plant.num_positions(models.robot)
    joints = builder.AddSystem(Demultiplexer([n, n]))
    builder.Connect(
        plant.get_state_output_port(models.robot), joints.get_input_port()
    )
    return {
        "joint_positions": joints.get_output_port(0),
        "joint_velocities": joints.get_output_port(1),
    }


def _AddFeedback(
    builder: DiagramBuilder, scene: Scene, feedback: str, seed: int
) -> System:
    """Adds what the controller goes by; all have the filter's period."""
    if feedback == "truth":
        model = MakePredictionModel(scene)
        return builder.AddNamedSystem(
            "truth",
            TruePoseSource(
                plant=model.diagram.plant(),
                objects=model.models.objects,
                period=scene.filter.period,
            ),
        )
    return AddEstimator(
        builder=builder,
        scene=scene,
        method=feedback,
        config=replace(DefaultConfig(scene, feedback), seed=seed),
    )


def _AddController(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    models: SceneModels,
    goal: np.ndarray,
) -> PushController:
    """Adds the controller of the push, and the servo that does as it says."""
    servo = builder.AddNamedSystem(
        "servo",
        CartesianServo(
            plant=plant,
            robot=models.robot,
            hand=plant.GetFrameByName(_HAND, models.robot),
            fingertip=np.array(_FINGERTIP),
        ),
    )
    controller = builder.AddNamedSystem(
        "push_controller",
        PushController(
            config=PushControllerConfig(goal=goal),
            start=servo.FingertipAtStart()[:2],
        ),
    )
    builder.Connect(controller.get_output_port(), servo.get_input_port())
    builder.Connect(
        servo.get_output_port(),
        plant.get_desired_state_input_port(models.robot),
    )
    return controller


def _SetStart(
    diagram: RobotDiagram,
    context: Context,
    models: SceneModels,
    task: PushTask,
) -> None:
    """Puts the object where the task has it, at its height on the table."""
    plant = diagram.plant()
    plant_context = diagram.mutable_plant_context(context)
    SetTrueObjects(
        plant=plant,
        context=plant_context,
        models=models,
        parameters=task.parameters,
    )
    body = plant.get_body(models.objects[0])
    height = body.EvalPoseInWorld(plant_context).translation()[2]
    x, y, yaw = task.start
    plant.SetFreeBodyPose(
        context=plant_context,
        body=body,
        X_JpJc=RigidTransform(RollPitchYaw(0, 0, yaw), [x, y, height]),
    )
