"""Writes a run of a tracker for viewers: as an MCAP file, with a video."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.dope_measurement import Detection
from pbpf_drake.log.dope_log_source import DopeLogSource
from pbpf_drake.log.joint_log_source import interpolate_joints
from pbpf_drake.log.log_records import Log
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.tracking.track_pictures import TrackPictures
from pbpf_drake.tracking.tracking_diagram import SceneOfLog
from pbpf_drake.views.track_mcap import TrackMcap


def WriteTrack(
    *,
    scene: Scene,
    log: Log,
    record: TrackRecord,
    mcap_filename: str | Path,
    images: Iterable[np.ndarray | None] | None = None,
    video_filename: str | Path | None = None,
) -> tuple[str, ...]:
    """Writes what was seen and estimated at every update.

    The MCAP file has the robot's joints, the detections that were used, the
    estimates, the particles and the log's images, if it has any. On the images
    are the wireframes of estimates (green) and of last detections (yellow, and
    thin if the detection is an old one). The video has all images. Where the
    log has none, it shows wireframes of the robot and of the fixed models.
    Pictures that can't be made cost only themselves.

    Args:
        scene: of the log.
        log: what was tracked.
        record: the run.
        mcap_filename: the MCAP file to write; its folder must exist.
        images: of the camera, one per update or None; height and width are
            the scene's; blue, green, red. None for no pictures at all.
        video_filename: the MP4 file to write, if any, in such a folder.

    Returns:
        A sentence for each: the video, the pictures, that couldn't be made.
    """
    scene = SceneOfLog(scene, log)
    seen = detections_at(scene, log, record.times)
    pictures = TrackPictures(
        scene=scene,
        record=record,
        images=images,
        video_filename=video_filename,
    )
    with (
        TrackMcap(filename=mcap_filename, start_time=log.start_time) as mcap,
        pictures,
    ):
        for i, time in enumerate(record.times):
            q, v = interpolate_joints(log.joints, float(time))
            mcap.WriteJoints(time, log.joints.names, q, v)
            _write_poses(mcap, record, i, seen[i])
            painted = pictures.Next(i, q, seen[i])
            if painted is not None:
                mcap.WriteImage(time, painted)
    return tuple(pictures.failures)


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
