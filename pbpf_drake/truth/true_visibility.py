"""How much of each object the scene's camera sees, by rendering it.

The truth counts pixels of label images. The ray caster of the filter's
visibility model has no part in it.
"""

from collections.abc import Sequence

import numpy as np
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    Role,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram
from pydrake.systems.framework import Context
from pydrake.systems.sensors import CameraInfo

from pbpf_drake.config.camera_config import CameraConfig

_RENDERER = "label"
# By how much width and height are reduced: a share of pixels needs no full
# resolution, and time grows with the number of pixels.
_SHRINK = 2


def visible_share(labels: np.ndarray, alone: np.ndarray, label: int) -> float:
    """Returns how much of an object an image shows, in [0, 1].

    Args:
        labels: an image whose pixels are the labels of what they show.
        alone: the same image if there were nothing but the object.
        label: the object's label.

    Returns:
        The object's pixels over those that it would have alone; 0 where it is
        outside of the image.
    """
    total = np.count_nonzero(alone == label)
    return np.count_nonzero(labels == label) / total if total else 0.0


class VisibilityCamera:
    """Measures how much of each object the scene's camera sees.

    It renders the scene as it is, and then each object alone.
    """

    def __init__(
        self,
        *,
        diagram: RobotDiagram,
        objects: Sequence[BodyIndex],
        camera: CameraConfig,
    ) -> None:
        """Prepares the contexts to render from.

        Args:
            diagram: its scene graph has what ``AddLabelRenderer`` adds.
            objects: the bodies of the K objects.
            camera: the scene's.
        """
        self._diagram = diagram
        self._labels = [int(body) for body in objects]
        self._camera = _make_camera(camera)
        self._X_WC = camera.pose()
        self._context = diagram.CreateDefaultContext()
        self._alone = [self._make_alone(body) for body in objects]

    def CalcVisibility(self, positions: np.ndarray) -> np.ndarray:
        """Returns (K,) visible shares in [0, 1].

        Args:
            positions: all positions of the diagram's plant.
        """
        labels = self._render(self._context, positions)
        return np.array(
            [
                visible_share(labels, self._render(alone, positions), label)
                for alone, label in zip(self._alone, self._labels, strict=True)
            ]
        )

    def _make_alone(self, body: BodyIndex) -> Context:
        """Returns a context in which nothing but one body is rendered."""
        plant: MultibodyPlant = self._diagram.plant()
        scene_graph: SceneGraph = self._diagram.scene_graph()
        context = self._context.Clone()
        scene_graph_context = self._diagram.mutable_scene_graph_context(context)
        for i in range(plant.num_bodies()):
            frame = plant.GetBodyFrameIdIfExists(BodyIndex(i))
            if frame is not None and i != int(body):
                scene_graph.RemoveRole(
                    scene_graph_context,
                    plant.get_source_id(),
                    frame,
                    Role.kPerception,
                )
        return context

    def _render(self, context: Context, positions: np.ndarray) -> np.ndarray:
        """Returns the label of every pixel, (height, width)."""
        plant: MultibodyPlant = self._diagram.plant()
        scene_graph: SceneGraph = self._diagram.scene_graph()
        plant.SetPositions(
            plant.GetMyMutableContextFromRoot(context), positions
        )
        query = scene_graph.get_query_output_port().Eval(
            self._diagram.scene_graph_context(context)
        )
        image = query.RenderLabelImage(
            camera=self._camera,
            parent_frame=scene_graph.world_frame_id(),
            X_PC=self._X_WC,
        )
        return image.data[:, :, 0].copy()


def AddLabelRenderer(scene_graph: SceneGraph) -> None:
    """Adds the renderer that ``VisibilityCamera`` needs."""
    scene_graph.AddRenderer(
        _RENDERER, MakeRenderEngineVtk(RenderEngineVtkParams())
    )


def _make_camera(camera: CameraConfig) -> ColorRenderCamera:
    width, height = camera.width // _SHRINK, camera.height // _SHRINK
    sx, sy = width / camera.width, height / camera.height
    # The centre of the first pixel is at 0 and its edge at -0.5, which is where
    # both images begin.
    info = CameraInfo(
        width=width,
        height=height,
        focal_x=camera.fx * sx,
        focal_y=camera.fy * sy,
        center_x=(camera.cx + 0.5) * sx - 0.5,
        center_y=(camera.cy + 0.5) * sy - 0.5,
    )
    core = RenderCameraCore(
        _RENDERER, info, ClippingRange(0.01, 10.0), RigidTransform()
    )
    return ColorRenderCamera(core)
