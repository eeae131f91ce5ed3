"""Draws a scene in Meshcat from its models' illustration geometry.

Paths in Meshcat are ``scene/MODEL/BODY`` for the robot and everything fixed.
The tracked objects are left to the caller, who knows where they are.
"""

from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, Rgba
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagramBuilder

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.scene.scene_models import AddSceneModels
from pbpf_drake.views.palette import (
    DETECTION_RGBA,
    ESTIMATE_RGBA,
    TRUTH_RGBA,
)
from pbpf_drake.views.visual_geometry import (
    DrawGeometries,
    GetVisualGeometries,
    VisualGeometry,
)

_MESHCAT_CAMERA = "/Cameras/default/rotated/<object>"
# Its vertical field of view (in radians).
_MESHCAT_FIELD_OF_VIEW = np.deg2rad(75.0)

_LEGEND = (
    ("estimate, in a cloud of its particles", ESTIMATE_RGBA),
    ("last detection, filled while it is new", DETECTION_RGBA),
    ("ground truth, where it is known", TRUTH_RGBA),
)
_LEGEND_STYLE = (
    "position:fixed; left:12px; bottom:12px; z-index:1; padding:6px 10px; "
    "font:14px sans-serif; background:rgba(255,255,255,0.8); "
    "border-radius:4px; pointer-events:none"
)


class SceneMeshcat:
    """The robot and the fixed models of a scene, drawn in Meshcat.

    Attributes:
        meshcat: where it is drawn.
        num_positions: n, how many positions the robot has.
        object_names: of the K tracked models.
        object_geometries: of each tracked model, by its name.
    """

    def __init__(self, *, meshcat: Meshcat, scene: Scene):
        """Draws the scene with its robot in the default configuration.

        Raises:
            ValueError: a model can't be parsed or can't play its role.
        """
        builder = RobotDiagramBuilder(time_step=0.0)
        self._models = AddSceneModels(builder.plant(), scene)
        self._diagram = builder.Build()
        self._plant = self._diagram.plant()
        self._camera = scene.camera
        self.meshcat = meshcat
        self.num_positions: int = self._plant.num_positions(self._models.robot)
        self.object_names = tuple(scene.object_names())
        self.object_geometries = {
            name: self._Geometries(body)
            for name, body in zip(
                self.object_names, self._models.objects, strict=True
            )
        }
        robot = self._plant.GetBodyIndices(self._models.robot)
        self._moving = [b for b in robot if self._Geometries(b)]
        context = self._plant.CreateDefaultContext()
        for body in [*self._moving, *self._models.fixed]:
            path = self._Path(body)
            DrawGeometries(meshcat, path, self._Geometries(body))
            X_WB = self._plant.get_body(body).EvalPoseInWorld(context)
            meshcat.SetTransform(path, X_WB)

    def SetJointPositions(self, q: np.ndarray, *, time: float) -> None:
        """Moves the robot.

        Args:
            q: (n,) in the order of the robot's model (radians or meters).
            time: when, in a recording (in seconds).
        """
        context = self._plant.CreateDefaultContext()
        self._plant.SetPositions(context, self._models.robot, q)
        for body in self._moving:
            X_WB = self._plant.get_body(body).EvalPoseInWorld(context)
            self.meshcat.SetTransform(
                self._Path(body), X_WB, time_in_recording=time
            )

    def SetCameraView(self) -> None:
        """Looks at the objects from where the scene's camera is, or nearly so.

        The field of view and the distance are those of the camera. The view is
        from 15 degrees higher, to look over what hides the objects from it.
        """
        context = self._plant.CreateDefaultContext()
        X_WC = self._camera.pose()
        p_WO = [
            self._plant.get_body(b).EvalPoseInWorld(context).translation()
            for b in self._models.objects
        ]
        forward = X_WC.rotation().col(2)
        depth = forward @ (np.mean(p_WO, axis=0) - X_WC.translation())
        # Where the objects are behind the camera, any distance will do.
        depth = max(float(depth), 0.1)
        target = X_WC.translation() + depth * forward
        offset = _raise_view(-depth * forward, -X_WC.rotation().col(1))
        # Meshcat's own camera isn't replaced, as a saved replay may set its
        # parts in any order. Zoom gives it the field of view of the scene's
        # camera.
        zoom = np.tan(0.5 * _MESHCAT_FIELD_OF_VIEW) / (
            0.5 * self._camera.height / self._camera.fy
        )
        self.meshcat.SetProperty(_MESHCAT_CAMERA, "zoom", float(zoom))
        self.meshcat.SetCameraPose(
            camera_in_world=target + offset, target_in_world=target
        )

    def _Path(self, index: BodyIndex) -> str:
        body = self._plant.get_body(index)
        model = self._plant.GetModelInstanceName(body.model_instance())
        return f"scene/{model}/{body.name()}".replace("::", "/")

    def _Geometries(self, index: BodyIndex) -> list[VisualGeometry]:
        frame = self._plant.GetBodyFrameIdOrThrow(index)
        inspector = self._diagram.scene_graph().model_inspector()
        return GetVisualGeometries(inspector, frame)


def _raise_view(offset: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Returns the offset from target to viewer, raised by 15 degrees.

    The viewer never looks straight down, as there the upward direction of the
    picture isn't defined.

    Args:
        offset: (3,) from the target to the camera (in meters).
        up: (3,) the upward direction in the camera's picture. It tells from
            which side to look if the camera does look straight down.
    """
    length = np.linalg.norm(offset)
    elevation = np.arcsin(offset[2] / length) + np.deg2rad(15.0)
    elevation = np.clip(elevation, np.deg2rad(20.0), np.deg2rad(60.0))
    side = offset[:2]
    if np.linalg.norm(side) < 0.1 * length:
        side = -up[:2]
    side = side / max(np.linalg.norm(side), 1e-9)
    return length * np.r_[np.cos(elevation) * side, np.sin(elevation)]


def SaveReplay(meshcat: Meshcat, filename: str | Path) -> None:
    """Writes what Meshcat shows and has recorded as one HTML file.

    The file plays in a browser without a network or a server. The recording
    must have been started, with meshcat.StartRecording().
    """
    meshcat.PublishRecording()
    entries = "".join(
        f'<div><span style="color:rgb({_css(color)})">&#9632;</span> '
        f"{meaning}</div>"
        for meaning, color in _LEGEND
    )
    legend = f'<div style="{_LEGEND_STYLE}">{entries}</div>'
    html = meshcat.StaticHtml().replace("<body>", f"<body>\n{legend}", 1)
    Path(filename).write_text(html, encoding="utf-8")


def _css(color: Rgba) -> str:
    return ",".join(f"{255 * c:.0f}" for c in (color.r(), color.g(), color.b()))
