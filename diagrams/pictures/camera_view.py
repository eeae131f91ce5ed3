"""Renders what a scene's camera sees."""

from collections.abc import Sequence

import numpy as np
from pydrake.geometry import (
    CalcObb,
    ClippingRange,
    ColorRenderCamera,
    LightParameter,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
)
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram, RobotDiagramBuilder
from pydrake.systems.sensors import CameraInfo

from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.scene.scene_models import AddSceneModels
from pbpf_drake.shapes.box_corners import box_edges

_BACKGROUND = np.array([0.93, 0.94, 0.95])
# From the camera, and from above.
_LIGHTS = [
    LightParameter(type="directional", frame="camera", intensity=0.7),
    LightParameter(
        type="directional",
        frame="world",
        direction=np.array([-0.2, 0.3, -1.0]),
        intensity=0.9,
    ),
]


class CameraView:
    """Renders a scene with its robot and objects where they are told to be."""

    def __init__(self, scene: Scene) -> None:
        """Builds the world of a scene."""
        builder = RobotDiagramBuilder(time_step=0.0)
        self._models = AddSceneModels(builder.plant(), scene)
        parameters = RenderEngineVtkParams(
            default_clear_color=_BACKGROUND, lights=_LIGHTS
        )
        builder.scene_graph().AddRenderer(
            "camera", MakeRenderEngineVtk(parameters)
        )
        self._diagram: RobotDiagram = builder.Build()
        self._camera = _make_camera(scene.camera)
        self._X_WC = scene.camera.pose()

    def Render(
        self, q: np.ndarray, poses: Sequence[RigidTransform]
    ) -> np.ndarray:
        """Returns an image (height, width, 3).

        Args:
            q: (n,) the robot's joints, in the order of its model.
            poses: K poses X_WO of the tracked objects.
        """
        plant = self._diagram.plant()
        context = self._diagram.CreateDefaultContext()
        plant_context = self._diagram.mutable_plant_context(context)
        plant.SetPositions(plant_context, self._models.robot, q)
        for body, X_WO in zip(self._models.objects, poses, strict=True):
            plant.SetFreeBodyPose(plant_context, plant.get_body(body), X_WO)
        scene_graph = self._diagram.scene_graph()
        query = scene_graph.get_query_output_port().Eval(
            self._diagram.scene_graph_context(context)
        )
        image = query.RenderColorImage(
            camera=self._camera,
            parent_frame=scene_graph.world_frame_id(),
            X_PC=self._X_WC,
        )
        return image.data[:, :, :3].copy()

    def BoxEdges(self, k: int) -> np.ndarray:
        """Returns the edges of the box around object k, (12, 2, 3), in it."""
        return _box_edges(self._diagram, self._models.objects[k])


def _make_camera(camera: CameraConfig) -> ColorRenderCamera:
    info = CameraInfo(
        width=camera.width,
        height=camera.height,
        focal_x=camera.fx,
        focal_y=camera.fy,
        center_x=camera.cx,
        center_y=camera.cy,
    )
    core = RenderCameraCore(
        "camera", info, ClippingRange(0.01, 10.0), RigidTransform()
    )
    return ColorRenderCamera(core)


def _box_edges(diagram: RobotDiagram, index: BodyIndex) -> np.ndarray:
    plant = diagram.plant()
    inspector = diagram.scene_graph().model_inspector()
    signs = (np.arange(8)[:, None] >> np.arange(3) & 1) * 2 - 1
    corners = []
    for geometry in plant.GetCollisionGeometriesForBody(plant.get_body(index)):
        box = CalcObb(inspector.GetShape(geometry))
        X_BA = inspector.GetPoseInFrame(geometry) @ box.pose()
        corners.append((X_BA @ (signs * box.half_width()).T).T)
    low, high = np.min(corners, axis=(0, 1)), np.max(corners, axis=(0, 1))
    return box_edges(0.5 * (high - low)) + 0.5 * (low + high)
