"""The log of one simulated run of a scene.

It is a pure function of its key, so it can be recorded anywhere, and stored. A
worker on another machine needs this package and, if the scene is a user's own
file, that file under the same path.
"""

from pathlib import Path
import tempfile

from pbpf_drake.diagrams.jobs.code_digest import code_digest
from pbpf_drake.diagrams.jobs.job_key import JobKey, check_key
from pbpf_drake.diagrams.jobs.scene_digests import ReadSceneFiles, SceneFiles
from pbpf_drake.diagrams.jobs.scene_run import SceneRun
from pbpf_drake.log.mcap_log_writer import WriteLog
from pbpf_drake.truth.truth_simulation import RecordRun


def recording_key(scene_run: SceneRun, files: SceneFiles) -> JobKey:
    """Returns all that a recorded log depends on.

    Args:
        scene_run: which.
        files: its scene's.
    """
    return {
        "scene": files.recorded_digest,
        "run": scene_run.run,
        "duration": scene_run.duration,
        "code": code_digest(__name__),
    }


def record(scene_run: SceneRun, key: JobKey) -> bytes:
    """Simulates a run; returns its log, an MCAP file.

    Args:
        scene_run: which.
        key: the recording_key of the program that asks.

    Raises:
        ValueError, FileNotFoundError: the scene can't be recorded, or this
            process finds another key.
    """
    files = ReadSceneFiles(scene_run.scene)
    check_key(key, recording_key(scene_run, files))
    scene = files.scene
    if scene_run.duration is not None:
        scene.recording.duration = scene_run.duration
    recording = RecordRun(scene=scene, run=scene_run.run)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        classes = {name: c for c, name in scene.object_by_class().items()}
        WriteLog(
            filename=path,
            scene_topics=scene.topics,
            log=recording.log,
            class_ids=classes,
        )
        return path.read_bytes()
