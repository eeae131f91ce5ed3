"""A detector whose errors are its own and that true occlusion blinds.

Under partial occlusion, good detections and outliers come mixed. What is
visible comes from rendered label images, not from the ray caster of the
filter's visibility model.
"""

from collections.abc import Sequence

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    Role,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagram
from pydrake.systems.framework import Context
from pydrake.systems.sensors import CameraInfo

from pbpf_drake.config.particle_filter_config import PoseStddev
from pbpf_drake.config.recording_config import DetectorConfig
from pbpf_drake.config.scene_config import CameraConfig
from pbpf_drake.log.log_records import DetectionRecord
from pbpf_drake.poses import quaternions
from pbpf_drake.truth.detection_outliers import (
    draw_directions,
    draw_outlier_error,
)

_RENDERER = "label"
# A share of pixels needs no full resolution; the time goes with the pixels.
_SHRINK = 2


def visible_share(labels: np.ndarray, alone: np.ndarray, label: int) -> float:
    """Returns how much of an object an image shows, in [0, 1].

    Args:
        labels: image of the label of what each pixel shows.
        alone: the same without any other object.
        label: the object's label.

    Returns:
        The object's pixels over those without other objects, or 0 where it
        is outside the image.
    """
    total = np.count_nonzero(alone == label)
    return np.count_nonzero(labels == label) / total if total else 0.0


def clearness(visibility: float, config: DetectorConfig) -> float:
    """Returns 0 where nothing is detected, 1 in a clear view."""
    low, high = config.hidden_visibility, config.clear_visibility
    return float(np.clip((visibility - low) / (high - low), 0.0, 1.0))


def detection_probability(visibility: float, config: DetectorConfig) -> float:
    """Returns the chance of a detection, from 0 (hidden) to 1 (half-way)."""
    return min(1.0, 2 * clearness(visibility, config))


def draw_bias(config: DetectorConfig, rng: np.random.Generator) -> np.ndarray:
    """Draws by how much a run's detections of an object are off, (6,).

    Args:
        config: how far.
        rng: where the numbers are drawn from.

    Returns:
        A rotation vector (in radians), then a translation (in meters).
    """
    ranges = config.bias_rotation, config.bias_position
    sizes = np.array([[rng.uniform(r.min, r.max)] for r in ranges])
    return (sizes * draw_directions(rng)).ravel()


def draw_pose_error(stddev: PoseStddev, rng: np.random.Generator) -> np.ndarray:
    """Draws an error of a pose, (6,).

    Args:
        stddev: of each axis of the position, and of the rotation angle.
        rng: where the numbers are drawn from.

    Returns:
        A rotation vector (in radians), then a translation (in meters).
    """
    axis = rng.standard_normal(3)
    axis /= np.linalg.norm(axis)
    rotation = stddev.rotation * rng.standard_normal() * axis
    return np.hstack([rotation, stddev.position * rng.standard_normal(3)])


def add_pose_error(X_CO: RigidTransform, error: np.ndarray) -> RigidTransform:
    """Returns X_CO turned about the object's origin, then shifted, in C.

    Args:
        X_CO: a pose.
        error: (6,) a rotation vector (in radians), then a translation (in
            meters), as from ``draw_pose_error``.
    """
    q = quaternions.from_rotation_vector(error[:3])
    R = RotationMatrix(Quaternion(wxyz=q)) @ X_CO.rotation()
    return RigidTransform(R, X_CO.translation() + error[3:])


class VisibilityCamera:
    """Measures how much of each object the scene's camera sees.

    It renders the scene as it is, and with each object alone.
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
            diagram: its scene graph went through ``AddLabelRenderer``.
            objects: bodies of the K objects.
            camera: the camera.
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
    """Adds what ``VisibilityCamera`` renders with."""
    scene_graph.AddRenderer(
        _RENDERER, MakeRenderEngineVtk(RenderEngineVtkParams())
    )


def _make_camera(camera: CameraConfig) -> ColorRenderCamera:
    width, height = camera.width // _SHRINK, camera.height // _SHRINK
    sx, sy = width / camera.width, height / camera.height
    # Pixel centres are at whole numbers, hence the halves.
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


class SimulatedDetector:
    """Answers for each image with what a detector would have found.

    All draws are made for every image, detected or not, so that a change of
    what is visible changes no other detection.
    """

    def __init__(
        self,
        *,
        config: DetectorConfig,
        names: Sequence[str],
        X_WC: RigidTransform,
        rng: np.random.Generator,
    ) -> None:
        """Draws this run's constant errors.

        Args:
            config: the detector's errors.
            names: of the K objects.
            X_WC: pose of the camera's optical frame in the world.
            rng: where all numbers are drawn from.
        """
        self._config = config
        self._names = tuple(names)
        self._X_CW = X_WC.inverse()
        self._rng = rng
        self._biases = [draw_bias(config, rng) for _ in names]

    def Detect(
        self,
        *,
        time: float,
        poses: Sequence[RigidTransform],
        visibility: np.ndarray,
    ) -> list[DetectionRecord]:
        """Returns the detections in one image, up to one per object.

        Args:
            time: when the image is taken (in seconds).
            poses: K true poses X_WO.
            visibility: (K,) visible shares in [0, 1].
        """
        config, rng = self._config, self._rng
        detections = []
        for name, bias, X_WO, share in zip(
            self._names, self._biases, poses, visibility, strict=True
        ):
            noise = draw_pose_error(config.noise, rng)
            occlusion = 1 - clearness(share, config)
            outlier = draw_outlier_error(occlusion, config, rng)
            if rng.uniform() >= detection_probability(share, config):
                continue
            X_CO = self._X_CW @ X_WO
            for error in (bias, noise, outlier):
                X_CO = add_pose_error(X_CO, error)
            detections.append(
                DetectionRecord(
                    name=name,
                    time=time,
                    received=time + config.latency,
                    X_CO=X_CO,
                )
            )
        return detections
