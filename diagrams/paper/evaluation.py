"""One evaluation of a method on the log of one run.

It is a pure function of its key, so it can be computed anywhere, and stored. It
takes and returns bytes, and reads only the scene's files. A worker on another
machine needs this package and, if the scene is a user's own file, that file
under the same path.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
import hashlib
import json
from pathlib import Path
import tempfile

import numpy as np

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.diagrams.jobs.code_digest import code_digest
from pbpf_drake.diagrams.jobs.job_key import JobKey, check_key
from pbpf_drake.diagrams.jobs.scene_digests import ReadSceneFiles, SceneFiles
from pbpf_drake.diagrams.jobs.scene_run import SceneRun, scene_name
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.results.pose_errors import (
    comparable_poses,
    position_error,
    rotation_error,
)
from pbpf_drake.results.pose_metrics import (
    add_error,
    add_s_error,
    mssd_error,
)
from pbpf_drake.results.symmetric_error import symmetric_rotation_error
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.scene.object_points import MakeObjectPoints
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.tracking.tracking_diagram import DefaultConfig, Track

# Known for every object and update; rotations in radians, others in meters.
METRICS = ("position", "rotation", "symmetric_rotation", "add", "add_s", "mssd")


@dataclass(frozen=True)
class Evaluation:
    """One method on one run, with one seed.

    Attributes:
        scene_run: what was recorded.
        method: "pbpf", "pbpf-v", "cvpf" or "dope".
        repeat: which of the repeats; the seed is a function of it.
        particles: their number; None is the method's own.
    """

    scene_run: SceneRun
    method: str
    repeat: int
    particles: int | None = None

    def name(self) -> str:
        """Returns what to call it, in a file's name as well."""
        return f"{self.scene_run.name()}-{self.method}-repeat_{self.repeat}"


@dataclass(frozen=True)
class Result:
    """What came out of one evaluation.

    Attributes:
        scene: the scene's name.
        run, method, repeat: see SceneRun and Evaluation.
        times: (N,) of the updates (in seconds).
        errors: by object and then by name of METRICS, (N,) each, NaN where
            unknown.
    """

    scene: str
    run: int
    method: str
    repeat: int
    times: np.ndarray
    errors: Mapping[str, Mapping[str, np.ndarray]]


def evaluation_config(
    evaluation: Evaluation, scene: Scene
) -> ParticleFilterConfig:
    """Returns the configuration of a method's filter for an evaluation.

    All evaluations of a scene have different seeds, except that the methods
    share them. No result depends on how fast the machine is.
    """
    config = DefaultConfig(scene, evaluation.method)
    if evaluation.particles is not None:
        config = replace(config, num_particles=evaluation.particles)
    seed = 1000 * evaluation.scene_run.run + evaluation.repeat
    count = replace(config.adaptive_count, to_period=False)
    return replace(config, seed=seed, parallelism=1, adaptive_count=count)


def evaluation_key(
    evaluation: Evaluation, log: bytes, files: SceneFiles
) -> JobKey:
    """Returns all that a result depends on.

    Args:
        evaluation: which.
        log: the MCAP file of its run.
        files: its scene's.
    """
    config = asdict(evaluation_config(evaluation, files.scene))
    # Results don't depend on how many processes there are.
    del config["parallelism"]
    return {
        "scene": files.tracked_digest,
        "log": hashlib.sha256(log).hexdigest(),
        "method": evaluation.method,
        "config": config,
        "code": code_digest(__name__),
    }


def evaluate(evaluation: Evaluation, log: bytes, key: JobKey) -> bytes:
    """Tracks a log and compares with its truth; returns a Result as JSON.

    Args:
        evaluation: what to evaluate.
        log: the MCAP file of its run.
        key: the evaluation_key of the program that asks.

    Raises:
        ValueError, FileNotFoundError: the log can't be tracked, or this
            process finds another key.
    """
    files = ReadSceneFiles(evaluation.scene_run.scene)
    check_key(key, evaluation_key(evaluation, log, files))
    scene = files.scene
    model = MakePredictionModel(scene)
    read = _read_log(log, scene, model.joint_names)
    track = Track(
        scene=scene,
        log=read,
        method=evaluation.method,
        config=evaluation_config(evaluation, scene),
    )
    errors = {
        name: compute_metrics(
            track,
            name,
            read,
            points=MakeObjectPoints(model, k),
            symmetry=scene.tracked[name].symmetry,
        )
        for k, name in enumerate(scene.object_names())
    }
    content = {
        "times": track.times.tolist(),
        "errors": {
            name: {metric: _plain(x) for metric, x in of_object.items()}
            for name, of_object in errors.items()
        },
    }
    return json.dumps(content, allow_nan=False).encode()


def compute_metrics(
    track: TrackRecord,
    name: str,
    log: Log,
    *,
    points: np.ndarray,
    symmetry: SymmetryConfig,
) -> dict[str, np.ndarray]:
    """Returns all METRICS of one object, (N,) each, NaN where unknown.

    Args:
        track: what an estimator produced.
        name: of the object.
        log: has its truth.
        points: (P, 3) on its surface (in meters).
        symmetry: of the object.
    """
    known, X, X_ref = comparable_poses(track, name, log.ground_truth.get(name))
    q, q_ref = X[:, :4], X_ref[:, :4]
    values = (
        position_error(X[:, 4:], X_ref[:, 4:]),
        rotation_error(q, q_ref),
        symmetric_rotation_error(q, q_ref, symmetry),
        add_error(X, X_ref, points),
        add_s_error(X, X_ref, points),
        mssd_error(X, X_ref, points, symmetry),
    )
    found = {}
    for metric, of_known in zip(METRICS, values, strict=True):
        found[metric] = np.full(len(known), np.nan)
        found[metric][known] = of_known
    return found


def read_result(evaluation: Evaluation, data: bytes) -> Result:
    """Returns the result that evaluate has written."""
    content = json.loads(data)
    return Result(
        scene=scene_name(evaluation.scene_run.scene),
        run=evaluation.scene_run.run,
        method=evaluation.method,
        repeat=evaluation.repeat,
        times=np.array(content["times"], dtype=float),
        errors={
            name: {m: np.array(x, dtype=float) for m, x in of_object.items()}
            for name, of_object in content["errors"].items()
        },
    )


def _plain(values: np.ndarray) -> list[float | None]:
    """Returns numbers for JSON, which has no NaN."""
    return [float(x) if np.isfinite(x) else None for x in values]


def _read_log(data: bytes, scene: Scene, joint_names: tuple[str, ...]) -> Log:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        path.write_bytes(data)
        return ReadLog(filename=path, scene=scene, joint_names=joint_names)
