"""What the simulated detector makes of simulated runs.

Each run is recorded once. What is drawn many times is the detector: its errors
for the visibility that the recording has.
"""

from collections.abc import Sequence

import numpy as np

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.detector.error_statistics import (
    describe_errors,
    describe_images,
)
from pbpf_drake.diagrams.jobs.scene_run import scene_path
from pbpf_drake.log.log_records import DetectionRecord, PoseRecord
from pbpf_drake.log.pose_interpolation import interpolate_poses
from pbpf_drake.poses import quaternions
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.truth.simulated_detector import SimulatedDetector
from pbpf_drake.truth.truth_simulation import Recording, RecordRun

# Time between two updates (in seconds).
_PERIOD = 0.16


def held_errors(
    detections: Sequence[DetectionRecord], truth: PoseRecord, scene: Scene
) -> np.ndarray:
    """Returns the errors of the last detection at every update, (N, 2).

    Args:
        detections: of one object, in order of time; at least one.
        truth: its true poses.
        scene: says where the camera is.
    """
    received = np.array([d.received for d in detections])
    updates = np.arange(_PERIOD, truth.times[-1], _PERIOD)
    updates = updates[updates >= received[0]]
    last = np.searchsorted(received, updates, side="right") - 1
    poses = [scene.camera.pose() @ d.X_CO for d in detections]
    q_WD = np.array([X.rotation().ToQuaternion().wxyz() for X in poses])
    p_WD = np.array([X.translation() for X in poses])
    q_WO, p_WO = interpolate_poses(truth, updates)
    return np.column_stack(
        [
            np.linalg.norm(p_WD[last] - p_WO, axis=1),
            quaternions.angle_between(q_WO, q_WD[last]),
        ]
    )


def draw_errors(
    recording: Recording, scene: Scene, seed: int
) -> dict[str, np.ndarray]:
    """Returns what another detector makes of a run: (N, 2) per object.

    An object that it never finds is left out.
    """
    truths = recording.log.ground_truth
    times = recording.image_times
    poses = [interpolate_poses(truth, times) for truth in truths.values()]
    detector = SimulatedDetector(
        config=scene.recording.detector,
        names=list(truths),
        X_WC=scene.camera.pose(),
        rng=np.random.default_rng(seed),
    )
    found: dict[str, list[DetectionRecord]] = {name: [] for name in truths}
    for i, time in enumerate(times):
        for detection in detector.Detect(
            time=time,
            poses=[rigid_transform(np.hstack([q[i], p[i]])) for q, p in poses],
            visibility=recording.visibility[i],
        ):
            found[detection.name].append(detection)
    return {
        name: held_errors(found[name], truth, scene)
        for name, truth in truths.items()
        if found[name]
    }


def DescribeRun(
    scene_and_run: tuple[str, int], draws: int
) -> list[tuple[str, dict[str, float]]]:
    """Records a run; returns a name and statistics per object and draw.

    Args:
        scene_and_run: the scene's name, and which of its runs.
        draws: how many detectors are drawn.
    """
    name, run = scene_and_run
    scene = LoadScene(scene_path(name))
    recording = RecordRun(scene=scene, run=run)
    images = {
        object_name: describe_images(visibility, scene.recording.detector)
        for object_name, visibility in zip(
            recording.log.ground_truth, recording.visibility.T, strict=True
        )
    }
    return [
        (object_name, images[object_name] | describe_errors(errors))
        for draw in range(draws)
        for object_name, errors in draw_errors(
            recording, scene, 1000 * run + draw
        ).items()
    ]
