"""Whether a robot's commanded motion runs into what is fixed."""

from collections.abc import Iterator, Sequence

import numpy as np
from pydrake.geometry import GeometryId
from pydrake.multibody.tree import JointIndex
from pydrake.planning import RobotDiagram
from pydrake.systems.framework import Context
from pydrake.trajectories import PiecewisePolynomial

from pbpf_drake.scene.scene_models import SceneModels

# How far apart the postures are that are checked (in seconds).
_PERIOD = 0.25


def CheckPath(
    *,
    diagram: RobotDiagram,
    models: SceneModels,
    joints: Sequence[JointIndex],
    trajectory: PiecewisePolynomial,
) -> None:
    """Checks the robot's postures along its path, four for every second.

    Args:
        diagram: the plant and its scene graph.
        models: who is who in the plant.
        joints: the robot's joints.
        trajectory: their positions over time, in the same order.

    Raises:
        ValueError: the robot and something fixed overlap.
    """
    plant = diagram.plant()
    context = diagram.CreateDefaultContext()
    plant_context = diagram.mutable_plant_context(context)
    rows = [plant.get_joint(j).position_start() for j in joints]
    positions = plant.GetPositions(plant_context)
    inspector = diagram.scene_graph().model_inspector()
    end = trajectory.end_time()
    for time in np.append(np.arange(0.0, end, _PERIOD), end):
        positions[rows] = trajectory.value(time)[:, 0]
        plant.SetPositions(plant_context, positions)
        for a, b in _robot_in_fixed(diagram, models, context):
            raise ValueError(
                f"recording.path at {time:.2f} s: {inspector.GetName(a)!r} "
                f"and {inspector.GetName(b)!r} run into each other"
            )


def _robot_in_fixed(
    diagram: RobotDiagram, models: SceneModels, context: Context
) -> Iterator[tuple[GeometryId, GeometryId]]:
    """Yields overlapping geometries, one the robot's and one fixed."""
    plant = diagram.plant()
    query = plant.get_geometry_query_input_port().Eval(
        diagram.plant_context(context)
    )
    inspector = query.inspector()
    for pair in query.ComputePointPairPenetration():
        a, b = (
            plant.GetBodyFromFrameId(inspector.GetFrameId(g))
            for g in (pair.id_A, pair.id_B)
        )
        if any(
            x.model_instance() == models.robot and y.index() in models.fixed
            for x, y in ((a, b), (b, a))
        ):
            yield pair.id_A, pair.id_B
