"""Where in the world the objects of a scene can be."""

import numpy as np

from pbpf_drake.scene.prediction_model import PredictionModel
from pbpf_drake.shapes.box_corners import box_corners

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
    points = [model.nominal_poses[:, 4:]]
    for body in [*model.models.fixed, *model.links]:
        X_WB = plant.get_body(body).EvalPoseInWorld(context)
        for geometry in model.geometries(body):
            box = inspector.GetObbInGeometryFrame(geometry)
            if box is not None:
                X_BG = inspector.GetPoseInFrame(geometry) @ box.pose()
                corners = box_corners(np.asarray(box.half_width()))
                points.append((X_WB @ X_BG).multiply(corners.T).T)
    together = np.concatenate(points)
    return np.stack(
        [np.min(together, axis=0) - MARGIN, np.max(together, axis=0) + MARGIN]
    )
