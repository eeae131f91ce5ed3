"""Where everything is that a scene knows, for comparing a log with it."""

from collections.abc import Sequence

import numpy as np
from pydrake.geometry import GeometryId, SceneGraphInspector

from pbpf_drake.shapes.bounding_boxes import MakeBoundingBoxes


def WorldBoxes(
    inspector: SceneGraphInspector,
    geometries: Sequence[Sequence[GeometryId]],
    X_WB: np.ndarray,
) -> np.ndarray:
    """Returns boxes around bodies along the world's axes, (B, 2, 3).

    Each has its lowest and its highest corner (in meters). A body without
    geometry is a point. A body with geometry that has no bounds, such as a half
    space, has no box.

    Args:
        inspector: knows the geometries.
        geometries: those of each body.
        X_WB: (B, 7) the bodies' poses.
    """
    boxes = []
    for of_body, pose in zip(geometries, X_WB, strict=True):
        if any(inspector.GetObbInGeometryFrame(g) is None for g in of_body):
            continue
        placed = MakeBoundingBoxes(inspector, [of_body]).at(pose[np.newaxis])
        points = placed.corners().reshape(-1, 3)
        points = points if len(points) else pose[np.newaxis, 4:]
        boxes.append((points.min(axis=0), points.max(axis=0)))
    return np.reshape(boxes, (-1, 2, 3))
