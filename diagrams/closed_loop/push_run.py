"""Runs one push to its end.

A run ends after 20 s, or when the fingertip has rested for 3 s because the
object seems to be at the goal. It is a success if the true centre of the object
is then within 40 mm of the goal, about half the length of the box.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.systems.analysis import Simulator

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.diagrams.closed_loop.closed_loop_diagram import MakeClosedLoop
from pbpf_drake.diagrams.closed_loop.push_task import draw_task

# How near to the goal the object has to be (in meters).
SUCCESS_DISTANCE = 0.04
# How long the robot has (in seconds).
DURATION = 20.0
# A run ends when the fingertip has rested for this long (in seconds).
_REST = 3.0
# How often a run is looked at (in seconds).
_LOOK = 0.5


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


def RunTask(
    scene: Scene, feedback: str, seed: int, duration: float = DURATION
) -> Outcome:
    """Draws a task and runs it in one simulation.

    Args:
        scene: see MakeClosedLoop.
        feedback: what the controller goes by, one of FEEDBACKS.
        seed: of the task.
        duration: the robot has so long (in seconds).
    """
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
