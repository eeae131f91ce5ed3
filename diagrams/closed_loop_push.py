"""Pushes an object to a goal behind an obstacle, by an estimate of its pose.

A manipulation diagram with the filter in its loop: an arm and its controllers,
a camera that can't see behind the obstacle, a detector, an estimator, and what
decides where to push by what the estimator says. The same is done with the
last detection in place of the filter's estimate, and with the truth:

    camera -> estimator -> push controller -> servo -> joint control -> arm
      ^           ^                                                      |
      +-----------+------------------ state of the truth ----------------+

All arrows but the last one start at discrete state, so there is no algebraic
loop. The truth is that of truth_model, not the filter's physics.

A run counts as a success if the true centre of the object is within 40 mm of
the goal, about half the length of the box, at the end: after 20 s, or when the
fingertip has rested for 3 s because the object seems to be at the goal.
"""

import argparse
from collections.abc import Sequence
import csv
from dataclasses import dataclass
from pathlib import Path
import sys

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.planning import RobotDiagram, RobotDiagramBuilder
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import Demultiplexer
from tqdm import tqdm

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.closed_loop.cartesian_servo import CartesianServo
from pbpf_drake.diagrams.closed_loop.push_controller import (
    PushConfig,
    PushController,
)
from pbpf_drake.diagrams.closed_loop.simulated_camera import SimulatedCamera
from pbpf_drake.diagrams.closed_loop.true_pose_source import TruePoseSource
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.filtering.add_particle_filter import (
    AddParticleFilter,
    ConfigForMethod,
)
from pbpf_drake.filtering.single_snapshot_estimator import (
    SingleSnapshotEstimator,
)
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import SceneModels, data_folder
from pbpf_drake.truth.truth_model import AddTruthModels, SetTrueObjects
from pbpf_drake.truth.truth_parameters import (
    TruthParameters,
    draw_truth_parameters,
)

# What the controller goes by.
FEEDBACKS = ("pbpf", "pbpf-v", "dope", "truth")
# How near to the goal the object has to be (in meters).
SUCCESS_DISTANCE = 0.04
# How long the robot has (in seconds).
DURATION = 20.0
# A run ends when the fingertip has rested for this long (in seconds).
_REST = 3.0
# How often a run is looked at (in seconds).
_LOOK = 0.5
_HAND = "panda_hand"
# The fingertips of the closed gripper in the hand's frame (in meters).
_FINGERTIP = (0.0, 0.0, 0.1124)


@dataclass(frozen=True)
class Task:
    """What is drawn at random for one run.

    Attributes:
        goal: (2,) where the object's centre has to go (in meters).
        start: (3,) where it is at first: x, y (in meters), yaw (in radians).
        parameters: friction and masses.
        seed: of the detector and of the filter.
    """

    goal: np.ndarray
    start: np.ndarray
    parameters: TruthParameters
    seed: int


def draw_task(scene: Scene, seed: int) -> Task:
    """Draws a goal behind the obstacle, and where the object is at first."""
    rng = np.random.default_rng(seed)
    return Task(
        goal=rng.uniform([0.40, 0.20], [0.52, 0.36]),
        start=rng.uniform([0.42, -0.13, -0.5], [0.48, -0.07, 0.5]),
        parameters=draw_truth_parameters(
            scene.recording, len(scene.tracked), rng
        ),
        seed=seed,
    )


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


def MakeClosedLoop(*, scene: Scene, feedback: str, task: Task) -> ClosedLoop:
    """Builds the diagram.

    Args:
        scene: closed_loop_push.yaml, or one like it.
        feedback: one of FEEDBACKS.
        task: what to do.
    """
    robot_builder = RobotDiagramBuilder(time_step=scene.recording.time_step)
    models = AddTruthModels(
        builder=robot_builder, scene=scene, parameters=task.parameters
    )
    plant, builder = robot_builder.plant(), robot_builder.builder()
    camera = builder.AddNamedSystem(
        "camera",
        SimulatedCamera(
            scene=scene,
            num_states=plant.num_multibody_states(),
            rng=np.random.default_rng([task.seed, 1]),
        ),
    )
    builder.Connect(plant.get_state_output_port(), camera.GetInputPort("state"))
    n = plant.num_positions(models.robot)
    joints = builder.AddSystem(Demultiplexer([n, n]))
    builder.Connect(
        plant.get_state_output_port(models.robot), joints.get_input_port()
    )
    estimator = _AddEstimator(builder, scene, feedback, task.seed)
    sources = {
        "joint_positions": joints.get_output_port(0),
        "joint_velocities": joints.get_output_port(1),
        "dope_measurement": camera.GetOutputPort("dope_measurement"),
        "state": plant.get_state_output_port(),
    }
    for name, source in sources.items():
        if estimator.HasInputPort(name):
            builder.Connect(source, estimator.GetInputPort(name))
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
            config=PushConfig(goal=task.goal),
            start=servo.FingertipAtStart()[:2],
        ),
    )
    builder.Connect(
        estimator.GetOutputPort("estimated_poses"),
        controller.GetInputPort("estimated_poses"),
    )
    builder.Connect(controller.get_output_port(), servo.get_input_port())
    builder.Connect(
        servo.get_output_port(),
        plant.get_desired_state_input_port(models.robot),
    )
    diagram = robot_builder.Build()
    context = diagram.CreateDefaultContext()
    _SetStart(diagram, context, models, task)
    return ClosedLoop(diagram, context, models, camera, controller)


def _AddEstimator(
    builder: DiagramBuilder, scene: Scene, feedback: str, seed: int
) -> LeafSystem:
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
    if feedback == "dope":
        return builder.AddNamedSystem(
            "single_snapshot_estimator",
            SingleSnapshotEstimator(
                object_names=scene.object_names(),
                nominal_poses=MakePredictionModel(scene).nominal_poses,
                period=scene.filter.period,
            ),
        )
    config = ConfigForMethod(scene.filter, feedback)
    config.seed = seed
    return AddParticleFilter(builder=builder, scene=scene, config=config)


def _SetStart(
    diagram: RobotDiagram, context: Context, models: SceneModels, task: Task
) -> None:
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


@dataclass(frozen=True)
class Outcome:
    """How a run ended.

    Attributes:
        feedback: what the controller went by.
        seed: of the task.
        goal: (2,) (in meters).
        end: (2,) where the object was at the end (in meters).
        hidden: share of the run in which less than half of it was visible.
    """

    feedback: str
    seed: int
    goal: np.ndarray
    end: np.ndarray
    hidden: float

    @property
    def distance(self) -> float:
        """Of the object's centre from the goal at the end (in meters)."""
        return float(np.linalg.norm(self.end - self.goal))

    @property
    def success(self) -> bool:
        """Whether the object is at the goal."""
        return self.distance <= SUCCESS_DISTANCE


def run_task(
    scene: Scene, feedback: str, seed: int, duration: float = DURATION
) -> Outcome:
    """Runs one task in one simulation."""
    task = draw_task(scene, seed)
    loop = MakeClosedLoop(scene=scene, feedback=feedback, task=task)
    simulator = Simulator(loop.diagram, loop.context)
    camera_context = loop.camera.GetMyContextFromRoot(loop.context)
    visibility = loop.camera.GetOutputPort("visibility")
    controller_context = loop.controller.GetMyContextFromRoot(loop.context)
    command = loop.controller.GetOutputPort("fingertip_position")
    hidden: list[bool] = []
    rested, last = 0.0, np.full(3, np.nan)
    while loop.context.get_time() < duration and rested < _REST:
        simulator.AdvanceTo(min(loop.context.get_time() + _LOOK, duration))
        hidden.append(visibility.Eval(camera_context)[0] < 0.5)
        fingertip = command.Eval(controller_context)
        rested = rested + _LOOK if np.array_equal(fingertip, last) else 0.0
        last = fingertip
    return Outcome(
        feedback=feedback,
        seed=seed,
        goal=task.goal,
        end=loop.object_position()[:2].copy(),
        hidden=float(np.mean(hidden)),
    )


def format_table(outcomes: Sequence[Outcome]) -> str:
    """Returns the success rates as a Markdown table."""
    lines = [
        "| feedback | successes | distance from the goal, median / 90th "
        "percentile [mm] |",
        "|---|---|---|",
    ]
    for feedback in dict.fromkeys(o.feedback for o in outcomes):
        mine = [o for o in outcomes if o.feedback == feedback]
        middle, most = np.percentile([o.distance for o in mine], [50, 90])
        count = sum(o.success for o in mine)
        lines.append(
            f"| {feedback} | {count} of {len(mine)} | {1e3 * middle:.0f} / "
            f"{1e3 * most:.0f} |"
        )
    return "\n".join(lines)


def _write(outcomes: Sequence[Outcome], filename: Path) -> None:
    with filename.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(
            ["feedback", "seed", "goal_x", "goal_y", "end_x", "end_y",
             "distance", "hidden_share", "success"]
        )  # fmt: skip
        for o in outcomes:
            numbers = [*o.goal, *o.end, o.distance, o.hidden]
            writer.writerow(
                [o.feedback, o.seed, *(f"{x:.4f}" for x in numbers),
                 int(o.success)]
            )  # fmt: skip


def _parse(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Pushes an object to goals behind an obstacle, by "
        "different estimates of its pose.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--feedback", nargs="+", choices=FEEDBACKS,
        default=["pbpf-v", "dope", "truth"],
        help="what the controller goes by")  # fmt: skip
    add("--goals", type=int, default=20, help="number of random goals")
    add("--first", type=int, default=0, help="seed of the first one")
    add("--out", type=Path, default=Path("closed_loop_push.csv"),
        help="CSV file to write")  # fmt: skip
    return parser.parse_args(argv)


def run(args: argparse.Namespace) -> None:
    """Runs all tasks; see _parse for the arguments."""
    scenes = data_folder("diagrams") / "scenes"
    scene = LoadScene(scenes / "closed_loop_push.yaml")
    outcomes = []
    tasks = [
        (feedback, args.first + i)
        for i in range(args.goals)
        for feedback in args.feedback
    ]
    for feedback, seed in tqdm(tasks, desc="push", unit="run"):
        outcomes.append(run_task(scene, feedback, seed))
        _write(outcomes, args.out)
    print(format_table(outcomes))
    print(f"Written to {args.out.resolve()}")


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    args = _parse(argv)
    return RunCommand("closed_loop_push", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
