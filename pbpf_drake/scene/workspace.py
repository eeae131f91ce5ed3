"""Where in the world the objects of a scene can be."""

import numpy as np

from pbpf_drake.poses.pose_conversion import pose_array
from pbpf_drake.scene.model_places import WorldBoxes
from pbpf_drake.scene.prediction_model import PredictionModel

# An object is not further than this from everything in the scene (in meters).
MARGIN = 3.0


def FindWorkspace(model: PredictionModel) -> np.ndarray:
    """Returns the lowest and the highest position of an object, (2, 3).

    That is a box around the robot, the fixed models and the nominal poses of
    the objects, and 3 m more to all sides. What has no bounds, as a half space,
    doesn't count.

    Args:
        model: the scene's.
    """
    plant = model.diagram.plant()
    context = plant.CreateDefaultContext()
    inspector = model.diagram.scene_graph().model_inspector()
    geometries, poses = [], []
    for body in [*model.models.fixed, *model.links]:
        X_WB = pose_array(plant.get_body(body).EvalPoseInWorld(context))
        for geometry in model.geometries(body):
            geometries.append([geometry])
            poses.append(X_WB)
    boxes = WorldBoxes(inspector, geometries, np.reshape(poses, (-1, 7)))
    points = np.concatenate([model.nominal_poses[:, 4:], *boxes])
    return np.stack(
        [np.min(points, axis=0) - MARGIN, np.max(points, axis=0) + MARGIN]
    )
