"""Pictures of a run: what its camera saw, with wireframes on it."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.dope_measurement import Detection
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_wireframes import SceneWireframes
from pbpf_drake.views.overlay import draw_edges, plain_image
from pbpf_drake.views.overlay_video import OverlayVideo
from pbpf_drake.views.palette import (
    DETECTION_BGR,
    ESTIMATE_BGR,
    SURROUNDINGS_BGR,
)


class TrackPictures:
    """Pictures of a run and a video of them; a context manager.

    After the first picture that can't be made there are no more, and a video
    that isn't whole is deleted.

    Attributes:
        failures: a sentence for everything that couldn't be made.
    """

    def __init__(
        self,
        *,
        scene: Scene,
        record: TrackRecord,
        images: Iterable[np.ndarray | None] | None,
        video_filename: str | Path | None,
    ):
        """Opens the video.

        Args:
            scene: with the camera where the log says that it was.
            record: the run.
            images: one per update or None, see WriteTrack; None for no
                pictures at all.
            video_filename: the MP4 file to write; None for no video.
        """
        self.failures: list[str] = []
        self._images = None if images is None else iter(images)
        self._painter = None if images is None else _Painter(scene, record)
        self._video: OverlayVideo | None = None
        if images is not None and video_filename is not None:
            self._filename = Path(video_filename)
            self._OpenVideo(scene.camera, record.period)

    def Next(
        self, i: int, q: np.ndarray, seen: dict[str, Detection]
    ) -> np.ndarray | None:
        """Paints the next picture, and adds it to the video.

        Args:
            i: index of the update.
            q: (n,) the robot's joints.
            seen: the last detections.

        Returns:
            The painted image of the camera (height, width, 3), blue, green,
            red; None where the camera has none, or it can't be painted.
        """
        if self._images is None or self._painter is None:
            return None
        try:
            image = next(self._images)
            if image is None and self._video is None:
                return None
            painted = self._painter.Paint(i, image, q, seen)
            if self._video is not None:
                self._video.Write(painted)
        except Exception as error:
            self._Fail(f"pictures can't be made from update {i + 1} on", error)
            return None
        return None if image is None else painted

    def __enter__(self) -> "TrackPictures":
        """Returns the pictures."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Completes the video."""
        if self._video is not None:
            self._video.__exit__(*exception)
            if exception[0] is not None:
                self._filename.unlink(missing_ok=True)

    def _OpenVideo(self, camera: CameraConfig, period: float) -> None:
        try:
            self._video = OverlayVideo(
                self._filename,
                width=camera.width,
                height=camera.height,
                period=period,
            )
        except Exception as error:
            self._filename.unlink(missing_ok=True)
            self.failures.append(str(error))

    def _Fail(self, what: str, error: Exception) -> None:
        self.failures.append(f"{what}: {type(error).__name__}: {error}")
        self._painter = None
        if self._video is not None:
            self._video.__exit__()
            self._video = None
            self._filename.unlink(missing_ok=True)


class _Painter:
    """Paints wireframes on images."""

    def __init__(self, scene: Scene, record: TrackRecord):
        self._camera = scene.camera
        self._record = record
        self._wireframes = SceneWireframes(MakePredictionModel(scene))

    def Paint(
        self,
        i: int,
        image: np.ndarray | None,
        q: np.ndarray,
        seen: dict[str, Detection],
    ) -> np.ndarray:
        """Returns an image with all wireframes of update i.

        Args:
            i: index of the update.
            image: of the camera, or None; it is left as it is.
            q: (n,) the robot's joints.
            seen: the last detections.
        """
        if image is None:
            painted = plain_image(self._camera)
            edges = self._wireframes.SurroundingEdges(q)
            self._Draw(painted, edges, SURROUNDINGS_BGR, 1)
        else:
            painted = image.copy()
        record = self._record
        for k, name in enumerate(record.object_names):
            if name in seen:
                edges = self._wireframes.ObjectEdges(k, seen[name].X_WO)
                width = 2 if record.detected[i, k] else 1
                self._Draw(painted, edges, DETECTION_BGR, width)
        for k in range(len(record.object_names)):
            if record.tracked[i, k]:
                X_WO = rigid_transform(record.poses[i, k])
                edges = self._wireframes.ObjectEdges(k, X_WO)
                self._Draw(painted, edges, ESTIMATE_BGR, 2)
        return painted

    def _Draw(
        self,
        image: np.ndarray,
        edges: np.ndarray,
        color: tuple[int, int, int],
        width: int,
    ) -> None:
        draw_edges(image, edges, self._camera, color=color, width=width)
