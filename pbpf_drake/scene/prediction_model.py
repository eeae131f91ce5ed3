"""What particles are predicted with, f_θ of Section 4.1, as the scene has it.

It holds the robot, the fixed models and the tracked objects of a scene, says
how they are called and shaped, and how the robot's links move. The physics
runs in particle plants that are made of it.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import GeometryId, Role
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram, RobotDiagramBuilder

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.poses.pose_conversion import pose_array
from pbpf_drake.scene.object_size import CheckObjectSizes
from pbpf_drake.scene.robot_joints import RobotJointNames
from pbpf_drake.scene.scene_models import AddSceneModels, SceneModels


@dataclass(frozen=True)
class PredictionModel:
    """A scene's models, and where things are in them.

    Attributes:
        diagram: the models as they are written, never simulated.
        models: the roles of its bodies.
        joint_names: n, the robot's joints in the order of robot_q.
        robot_q: (n,) indices of the robot's joints into the plant's q.
        links: L, the robot's bodies that can touch something.
        nominal_poses: (K, 7) the scene's own poses of the objects.
    """

    diagram: RobotDiagram
    models: SceneModels
    joint_names: tuple[str, ...]
    robot_q: np.ndarray
    links: tuple[BodyIndex, ...]
    nominal_poses: np.ndarray

    def geometries(self, body: BodyIndex) -> list[GeometryId]:
        """Returns the collision geometries of a body."""
        return _geometries(self.diagram, body)

    def fixed_poses(self) -> np.ndarray:
        """Returns the poses of the fixed bodies in the world, (F, 7)."""
        plant = self.diagram.plant()
        context = plant.CreateDefaultContext()
        poses = [
            pose_array(plant.get_body(body).EvalPoseInWorld(context))
            for body in self.models.fixed
        ]
        return np.reshape(poses, (-1, 7))


def MakePredictionModel(scene: Scene) -> PredictionModel:
    """Builds the prediction model of a scene.

    Raises:
        ValueError: the scene's models don't fit their roles, or a tracked
            object isn't given in meters.
    """
    builder = RobotDiagramBuilder(time_step=0.0)
    plant = builder.plant()
    models = AddSceneModels(plant, scene)
    plant.Finalize()
    try:
        joint_names = tuple(RobotJointNames(plant, models.robot))
    except ValueError as error:
        raise ValueError(f"Scene {scene.path}: robot: {error}") from error
    diagram = builder.Build()
    CheckObjectSizes(
        scene=scene,
        inspector=diagram.scene_graph().model_inspector(),
        geometries=[_geometries(diagram, b) for b in models.objects],
    )
    plant = diagram.plant()
    positions = plant.GetPositions(plant.CreateDefaultContext())
    rows = np.arange(plant.num_positions())
    starts = [
        plant.get_body(b).floating_positions_start() for b in models.objects
    ]
    return PredictionModel(
        diagram=diagram,
        models=models,
        joint_names=joint_names,
        robot_q=plant.GetPositionsFromArray(models.robot, rows).astype(int),
        links=tuple(
            b
            for b in plant.GetBodyIndices(models.robot)
            if _geometries(diagram, b)
        ),
        nominal_poses=np.array([positions[s : s + 7] for s in starts]),
    )


def _geometries(diagram: RobotDiagram, body: BodyIndex) -> list[GeometryId]:
    # Not the plant's own list: it moves when geometry is registered.
    frame = diagram.plant().GetBodyFrameIdOrThrow(body)
    inspector = diagram.scene_graph().model_inspector()
    return inspector.GetGeometries(frame, Role.kProximity)
