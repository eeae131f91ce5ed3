"""In which particles objects may penetrate fixed models or each other.

In most they don't, and it takes much less to find that out, for all particles
at once, than to push objects out. In doubt, they do.
"""

import numpy as np

from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.motion.penetration import TOUCH, is_too_deep
from pbpf_drake.scene.prediction_model import PredictionModel
from pbpf_drake.shapes.bounding_boxes import (
    MakeBoundingBoxes,
    PlacedBoxes,
    least_distances,
)
from pbpf_drake.shapes.contact_points import (
    INSET,
    REST_DEPTH,
    MakeContactPoints,
)


class PenetrationCheck:
    """Looks for objects that penetrate fixed models and each other.

    Args:
        model: the scene's models.
        contacts: finds the contacts with fixed models, of the same scene.
    """

    def __init__(
        self, *, model: PredictionModel, contacts: FixedContacts
    ) -> None:
        self._contacts = contacts
        inspector = model.diagram.scene_graph().model_inspector()
        objects = [model.geometries(b) for b in model.models.objects]
        fixed = [model.geometries(b) for b in model.models.fixed]
        bounded = [
            [g for g in of_body if inspector.GetObbInGeometryFrame(g)]
            for of_body in fixed
        ]
        self._objects = MakeBoundingBoxes(inspector, objects)
        self._fixed = MakeBoundingBoxes(inspector, bounded).at(
            model.fixed_poses()
        )
        has_points = np.array(
            [
                len(MakeContactPoints(inspector.GetShape(g)).p_GS) > 0
                for of_body in objects
                for g in of_body
            ]
        )
        # Where a geometry has points, these are looked at one by one, and its
        # core is this much smaller.
        self._allowed = np.where(has_points, INSET, TOUCH)
        # A half space has no box around it. Points in it are found all the
        # same, but geometry without points isn't.
        self._unsure = bounded != fixed and not has_points.all()

    def MayPenetrate(self, poses: np.ndarray, active: np.ndarray) -> np.ndarray:
        """Returns for which particles something may be too deep, (M,).

        Args:
            poses: (M, K, 7) of the objects.
            active: (K,) which of them count.
        """
        found = np.full(len(poses), self._unsure)
        contacts = self._contacts.Find(poses)
        deep = is_too_deep(contacts.depths, contacts.normals[:, 2])
        found[contacts.particles[deep & active[contacts.objects]]] = True
        counts = active[self._objects.bodies]
        boxes = self._objects.at(poses)
        gaps = least_distances(boxes, self._fixed).min(axis=-1, initial=np.inf)
        found |= ((gaps < -self._allowed) & counts).any(axis=-1)
        return found | _crowded(boxes, counts)


def _crowded(boxes: PlacedBoxes, counts: np.ndarray) -> np.ndarray:
    """Returns for which particles objects may touch each other, (M,).

    Args:
        boxes: of M particles, (M, ...).
        counts: (G,) which of them count.
    """
    pairs = (boxes.bodies[:, None] < boxes.bodies) & counts[:, None] & counts
    if not pairs.any():
        return np.zeros(len(boxes.centers), dtype=bool)
    gaps = least_distances(boxes, boxes)
    return ((gaps < REST_DEPTH) & pairs).any(axis=(-2, -1))
