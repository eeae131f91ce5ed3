"""What the benchmark tracks: the pushes of two logs, from touch to rest.

The time before the robot touches anything is easy for a motion model, so it is
cut off. With one object the log is the default one, of Scene 1 of the paper;
with three it is like its Scene 5. Both were made by record_scene.py. The log's
detections keep the particles near the objects until these are hidden: the one
object for the last 8 s, and two of the three from time to time.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import (
    DetectionRecord,
    JointRecord,
    Log,
    PoseRecord,
)
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder

# Scenes and logs of this name, by the number of their tracked objects.
WORKLOADS = {1: "cheezit_1", 3: "cheezit_gelatin_soup"}
# A push begins when the object is this far from where it starts, and ends when
# the object is this near to where it comes to rest (in meters).
_MOVED = 1e-3


@dataclass(frozen=True)
class Workload:
    """A scene, and the part of its log in which all objects are pushed.

    Attributes:
        scene: robot, objects and camera.
        log: the part of it, from time 0.
    """

    scene: Scene
    log: Log


def LoadWorkload(num_objects: int) -> Workload:
    """Returns the push of so many objects, one of WORKLOADS."""
    folder, name = data_folder("diagrams"), WORKLOADS[num_objects]
    scene = LoadScene(folder / "scenes" / f"{name}.yaml")
    log = ReadLog(
        filename=folder / "logs" / f"{name}.mcap",
        scene=scene,
        joint_names=MakePredictionModel(scene).joint_names,
    )
    begin, end = find_push(log.ground_truth.values())
    return Workload(scene, cut_log(log, begin, end))


def find_push(truths: Iterable[PoseRecord]) -> tuple[float, float]:
    """Returns when all objects have been moved, and when the first rests.

    Args:
        truths: where the objects are; all of them are pushed.

    Returns:
        Two times (in seconds).
    """
    begins, ends = [], []
    for truth in truths:
        since_start = np.linalg.norm(truth.p_WO - truth.p_WO[0], axis=1)
        until_end = np.linalg.norm(truth.p_WO - truth.p_WO[-1], axis=1)
        begins.append(truth.times[np.argmax(since_start > _MOVED)])
        ends.append(truth.times[np.argmax(until_end < _MOVED)])
    return max(begins), min(ends)


def cut_log(log: Log, begin: float, end: float) -> Log:
    """Returns the part of a log between two times, without ground truth.

    Its time 0 is that of the first joint state that is kept.
    """
    joints = log.joints
    keep = (joints.times >= begin) & (joints.times <= end)
    start = joints.times[keep][0]
    velocities = joints.velocities
    return Log(
        joints=JointRecord(
            names=joints.names,
            times=joints.times[keep] - start,
            positions=joints.positions[keep],
            velocities=None if velocities is None else velocities[keep],
        ),
        detections=tuple(
            _shift(detection, start)
            for detection in log.detections
            if detection.time >= start and detection.received <= end
        ),
        start_time=log.start_time + round(1e9 * start),
    )


def _shift(detection: DetectionRecord, start: float) -> DetectionRecord:
    return replace(
        detection,
        time=detection.time - start,
        received=detection.received - start,
    )
