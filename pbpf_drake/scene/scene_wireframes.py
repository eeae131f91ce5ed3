"""The wireframes of everything in a scene, from its collision geometry."""

from collections.abc import Iterable

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex

from pbpf_drake.scene.prediction_model import PredictionModel
from pbpf_drake.shapes.wireframes import ShapeEdges


class SceneWireframes:
    """Edges of the objects, the robot and the fixed models of a scene."""

    def __init__(self, model: PredictionModel):
        """Makes the edges of all bodies.

        Args:
            model: the scene's.
        """
        self._model = model
        self._plant = model.diagram.plant()
        self._context = self._plant.CreateDefaultContext()
        self._objects = [self._Edges(body) for body in model.models.objects]
        self._links = {body: self._Edges(body) for body in model.links}
        self._fixed = self._InWorld(
            (body, self._Edges(body)) for body in model.models.fixed
        )

    def ObjectEdges(self, k: int, X_WO: RigidTransform) -> np.ndarray:
        """Returns the edges of object k at a pose, in the world, (E, 2, 3)."""
        return _transform(X_WO, self._objects[k])

    def SurroundingEdges(self, q: np.ndarray) -> np.ndarray:
        """Returns the edges of the robot and the fixed models, in the world.

        Args:
            q: (n,) the robot's joint positions, in the order of its model.

        Returns:
            (E, 2, 3), in meters.
        """
        positions = self._plant.GetPositions(self._context)
        positions[self._model.robot_q] = q
        self._plant.SetPositions(self._context, positions)
        links = self._InWorld(self._links.items())
        return np.concatenate([self._fixed, links])

    def _Edges(self, body: BodyIndex) -> np.ndarray:
        """Returns the edges of a body, in its frame."""
        inspector = self._model.diagram.scene_graph().model_inspector()
        edges = [
            _transform(
                inspector.GetPoseInFrame(geometry),
                ShapeEdges(inspector.GetShape(geometry)),
            )
            for geometry in self._model.geometries(body)
        ]
        return np.concatenate([np.empty((0, 2, 3)), *edges])

    def _InWorld(
        self, bodies: Iterable[tuple[BodyIndex, np.ndarray]]
    ) -> np.ndarray:
        moved = [
            _transform(
                self._plant.get_body(body).EvalPoseInWorld(self._context), edges
            )
            for body, edges in bodies
        ]
        return np.concatenate([np.empty((0, 2, 3)), *moved])


def _transform(X_AB: RigidTransform, edges_B: np.ndarray) -> np.ndarray:
    return edges_B @ X_AB.rotation().matrix().T + X_AB.translation()
