"""A scene's models as they are written: what the prediction starts from.

The prediction, f_θ of Section 4.1, isn't simulated in this plant: it only tells
how the robot, the fixed models and the tracked objects are named and shaped,
and how the robot's links move. The plants that are simulated are made from it.
"""

from dataclasses import dataclass, replace

import numpy as np
from pydrake.geometry import GeometryId, Role
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram, RobotDiagramBuilder

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.model_facts import ModelFacts
from pbpf_drake.poses.pose_conversion import pose_array
from pbpf_drake.scene.mimic_joints import MimicJoints
from pbpf_drake.scene.model_places import WorldBoxes
from pbpf_drake.scene.object_size import CheckObjectSizes
from pbpf_drake.scene.robot_joints import RobotJointNames
from pbpf_drake.scene.scene_models import (
    AddSceneModels,
    MakePackageMap,
    SceneModels,
)
from pbpf_drake.scene.scene_warnings import (
    CarrierWarnings,
    WarnOnce,
    robot_warnings,
)


@dataclass(frozen=True)
class PredictionModel:
    """A scene's models, and where things are in them.

    Attributes:
        diagram: the plant and its scene graph, which are never simulated.
        models: the roles of the plant's bodies.
        joint_names: names of the robot's n joints, in the order of robot_q.
        robot_q: (n,) where the robot's joints are among the plant's positions.
        links: the robot's L bodies that have collision geometry.
        nominal_poses: (K, 7) the poses that the scene gives the objects.
        facts: what a log is completed with and compared to.
        warnings: sentences on what probably isn't as it was meant.
    """

    diagram: RobotDiagram
    models: SceneModels
    joint_names: tuple[str, ...]
    robot_q: np.ndarray
    links: tuple[BodyIndex, ...]
    nominal_poses: np.ndarray
    facts: ModelFacts
    warnings: tuple[str, ...] = ()

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

    Its warnings are also said in Python's log, once.

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
    model = PredictionModel(
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
        facts=_facts(scene, diagram, models),
    )
    warnings = _warnings(scene, model)
    WarnOnce(warnings)
    return replace(model, warnings=(*models.warnings, *warnings))


def _facts(
    scene: Scene, diagram: RobotDiagram, models: SceneModels
) -> ModelFacts:
    plant = diagram.plant()
    context = plant.CreateDefaultContext()
    bodies = [BodyIndex(i) for i in range(1, plant.num_bodies())]
    X_WB = np.array(
        [pose_array(plant.get_body(b).EvalPoseInWorld(context)) for b in bodies]
    )
    p_WB = dict(zip(bodies, X_WB[:, 4:], strict=True))
    return ModelFacts(
        mimics=MimicJoints(scene, MakePackageMap(scene)),
        nominal={
            name: p_WB[body]
            for name, body in zip(scene.tracked, models.objects, strict=True)
        },
        boxes=WorldBoxes(
            diagram.scene_graph().model_inspector(),
            [_geometries(diagram, b) for b in bodies],
            X_WB,
        ),
    )


def _warnings(scene: Scene, model: PredictionModel) -> list[str]:
    plant, robot = model.diagram.plant(), model.models.robot
    links = [plant.get_body(b).name() for b in plant.GetBodyIndices(robot)]
    return [
        f"Scene {scene.path or '(without a file)'}: {warning}"
        for warning in robot_warnings(scene.robot, links, len(model.links))
        + CarrierWarnings(
            inspector=model.diagram.scene_graph().model_inspector(),
            names=scene.object_names(),
            objects=[model.geometries(b) for b in model.models.objects],
            poses=model.nominal_poses,
            fixed=[model.geometries(b) for b in model.models.fixed],
            fixed_poses=model.fixed_poses(),
        )
    ]


def _geometries(diagram: RobotDiagram, body: BodyIndex) -> list[GeometryId]:
    # Not from the plant: its list may move in memory when geometry is
    # registered, and Python would go on reading at the old place.
    frame = diagram.plant().GetBodyFrameIdOrThrow(body)
    inspector = diagram.scene_graph().model_inspector()
    return inspector.GetGeometries(frame, Role.kProximity)
