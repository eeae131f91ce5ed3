"""Warns of detections that the filter can make little of."""

from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.detection_ages import age_warning
from pbpf_drake.log.detection_places import place_warnings
from pbpf_drake.log.log_records import DetectionRecord


def detection_warnings(
    records: Sequence[DetectionRecord],
    *,
    scene: Scene,
    X_WC: RigidTransform,
    boxes: np.ndarray,
) -> list[str]:
    """Returns sentences on the detections of one object.

    Args:
        records: N of them; may be empty.
        scene: has the camera's image and the filter's numbers.
        X_WC: the camera's pose in the world.
        boxes: (B, 2, 3) around all that is known in the scene, see ModelFacts.
    """
    if not records:
        return []
    p_CO = np.array([r.X_CO.translation() for r in records])
    config = scene.filter
    late = age_warning(
        np.array([r.time for r in records]),
        np.array([r.received for r in records]),
        period=config.period,
        max_age=config.max_detection_age,
    )
    misplaced = place_warnings(
        p_CO, camera=scene.camera, X_WC=X_WC, boxes=boxes
    )
    return [
        f"detections of {records[0].name!r}: {clause}"
        for clause in [late, *misplaced]
        if clause
    ]
