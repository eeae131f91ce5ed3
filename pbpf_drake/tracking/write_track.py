"""Writes a run of a tracker for viewers: as an MCAP file and as a video."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.dope_measurement import Detection
from pbpf_drake.log.dope_log_source import DopeLogSource
from pbpf_drake.log.joint_log_source import interpolate_joints
from pbpf_drake.log.log_records import Log
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_wireframes import SceneWireframes
from pbpf_drake.tracking.tracking_diagram import SceneOfLog
from pbpf_drake.views.overlay import draw_edges, plain_image
from pbpf_drake.views.overlay_video import OverlayVideo
from pbpf_drake.views.palette import (
    DETECTION_BGR,
    ESTIMATE_BGR,
    SURROUNDINGS_BGR,
)
from pbpf_drake.views.track_mcap import TrackMcap


def WriteTrack(
    *,
    scene: Scene,
    log: Log,
    record: TrackRecord,
    images: Iterable[np.ndarray | None],
    mcap_filename: str | Path,
    video_filename: str | Path,
) -> None:
    """Writes what was seen and estimated at every update.

    The MCAP file has the robot's joints, the detections that were used, the
    estimates, the particles and the log's images, if it has any. On the images
    are the wireframes of estimates (green) and of last detections (yellow, and
    thin if the detection is an old one). The video has all images. Where the
    log has none, it shows wireframes of the robot and of the fixed models.

    Args:
        scene: of the log.
        log: what was tracked.
        record: the run.
        images: of the camera, one per update or None; height and width are
            the scene's; blue, green, red.
        mcap_filename: the MCAP file to write; its folder must exist.
        video_filename: the MP4 file to write; its folder must exist.

    Raises:
        ValueError: OpenCV can't write a video of that size.
    """
    scene = SceneOfLog(scene, log)
    seen = detections_at(scene, log, record.times)
    painter = _Painter(scene, record)
    camera = scene.camera
    with (
        TrackMcap(filename=mcap_filename, start_time=log.start_time) as mcap,
        OverlayVideo(
            video_filename,
            width=camera.width,
            height=camera.height,
            period=scene.filter.period,
        ) as video,
    ):
        for i, image in zip(range(len(record.times)), images, strict=True):
            q, v = interpolate_joints(log.joints, float(record.times[i]))
            mcap.WriteJoints(record.times[i], log.joints.names, q, v)
            _write_poses(mcap, record, i, seen[i])
            painted = painter.Paint(i, image, q, seen[i])
            if image is not None:
                mcap.WriteImage(record.times[i], painted)
            video.Write(painted)


def detections_at(
    scene: Scene, log: Log, times: Iterable[float]
) -> list[dict[str, Detection]]:
    """Returns the last detections that were known at given times, by object.

    Args:
        scene: with the camera that the detector looks through.
        log: has all detections.
        times: of updates (in seconds).
    """
    source = DopeLogSource(detections=log.detections, X_WC=scene.camera.pose())
    context = source.CreateDefaultContext()
    seen = []
    for time in times:
        context.SetTime(float(time))
        measurement = source.GetOutputPort("dope_measurement").Eval(context)
        seen.append(dict(measurement.detections))
    return seen


def _write_poses(
    mcap: TrackMcap, record: TrackRecord, i: int, seen: dict[str, Detection]
) -> None:
    time = float(record.times[i])
    for k, name in enumerate(record.object_names):
        if record.detected[i, k]:
            mcap.WriteDetection(time, name, seen[name])
        mcap.WriteEstimate(
            time, name, record.poses[i, k], record.covariances[i, k]
        )
        if record.particles.shape[1]:
            mcap.WriteParticles(time, name, record.particles[i, :, k])


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
