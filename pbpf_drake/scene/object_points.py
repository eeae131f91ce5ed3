"""Points on a tracked object's surface, for errors that depend on its shape."""

import numpy as np
from pydrake.geometry import Capsule
from pydrake.math import RigidTransform

from pbpf_drake.scene.prediction_model import PredictionModel
from pbpf_drake.shapes.contact_points import MakeContactPoints
from pbpf_drake.shapes.surface_sampling import BodySurface

_NUM_POINTS = 500


def MakeObjectPoints(
    model: PredictionModel, index: int, num_points: int = _NUM_POINTS
) -> np.ndarray:
    """Returns points in the frame of an object, (P, 3) (in meters).

    First come random points on the surface of its collision geometry, the same
    ones at every call. Then come the corners of boxes and meshes, and points on
    the rims of cylinders: no other point of the object moves farther than the
    one of those that moves the farthest.

    Args:
        model: of the scene.
        index: of the object, in the scene's order.
        num_points: how many random points there are.

    Raises:
        ValueError: it has no surface of a finite area.
    """
    inspector = model.diagram.scene_graph().model_inspector()
    geometries = model.geometries(model.models.objects[index])
    shapes = [inspector.GetShape(g) for g in geometries]
    poses: list[RigidTransform] = [
        inspector.GetPoseInFrame(g) for g in geometries
    ]
    if not shapes:
        raise ValueError(
            f"tracked object {index} has no collision geometry; expected some"
        )
    surface = BodySurface(shapes=shapes, X_BG=poses)
    points = [surface.sample(np.random.default_rng(0), num_points)]
    for shape, X_BG in zip(shapes, poses, strict=True):
        # A capsule's contact points are inside of it, not on its surface.
        if not isinstance(shape, Capsule):
            p_GS = MakeContactPoints(shape).p_GS
            points.append(p_GS @ X_BG.rotation().matrix().T)
            points[-1] += X_BG.translation()
    return np.vstack(points)
