"""One recorded run of a scene, and one evaluation of a method on it.

Both are pure functions of what they are given, so that they can be computed
anywhere, and stored under the key of all that they depend on. They take and
return bytes, and read only the scene's files: a worker on another machine
needs this package, and a scene file of one's own under the same path.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
import json
from pathlib import Path
import tempfile

import numpy as np

from pbpf_drake.diagrams.code_digest import code_digest
from pbpf_drake.log import Log
from pbpf_drake.log_reader import ReadLog
from pbpf_drake.mcap_log_writer import WriteLog
from pbpf_drake.object_points import MakeObjectPoints
from pbpf_drake.particle_filter_config import ParticleFilterConfig
from pbpf_drake.pose_errors import (
    comparable_poses,
    position_error,
    rotation_error,
)
from pbpf_drake.pose_metrics import (
    add_error,
    add_s_error,
    mssd_error,
    symmetric_rotation_error,
)
from pbpf_drake.prediction_model import MakePredictionModel
from pbpf_drake.scene import LoadScene, Scene
from pbpf_drake.scene_models import data_folder
from pbpf_drake.symmetry import SymmetryConfig
from pbpf_drake.track_record import TrackRecord
from pbpf_drake.tracking import DefaultConfig, Track
from pbpf_drake.truth_simulation import RecordRun

# Of every object and update; the rotations in radians, the others in meters.
METRICS = ("position", "rotation", "symmetric_rotation", "add", "add_s", "mssd")


@dataclass(frozen=True)
class SceneRun:
    """One simulated run of a scene.

    Attributes:
        scene: the name of a scene of this package, or the path of a file.
        run: which run; all that differs between runs is a function of it.
        duration: of the log (in seconds); None is the scene's.
    """

    scene: str
    run: int
    duration: float | None = None

    def name(self) -> str:
        """Returns what to call it, in a file's name as well."""
        return f"{scene_name(self.scene)}-run_{self.run}"


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


def scene_name(scene: str) -> str:
    """Returns the name of a scene, from its name or its file's path."""
    return Path(scene).stem


def scene_path(scene: str) -> Path:
    """Returns the file of a scene of this package, or the path as it is."""
    shipped = data_folder("diagrams") / "scenes" / f"{scene}.yaml"
    return shipped if shipped.is_file() else Path(scene)


def load_run(scene_run: SceneRun) -> Scene:
    """Returns the scene, as this run of it is recorded.

    Raises:
        FileNotFoundError, ValueError: there is no such scene.
    """
    scene = LoadScene(scene_path(scene_run.scene))
    if scene_run.duration is not None:
        scene.recording.duration = scene_run.duration
    return scene


def evaluation_code() -> str:
    """Returns the digest of the code here, to compare it with a worker's."""
    return code_digest(__name__)


def evaluation_config(
    evaluation: Evaluation, scene: Scene
) -> ParticleFilterConfig:
    """Returns the configuration of a method's filter for an evaluation.

    No two evaluations of a scene have the same seed, but for the methods. None
    depends on how fast the machine is.
    """
    config = DefaultConfig(scene, evaluation.method)
    if evaluation.particles is not None:
        config = replace(config, num_particles=evaluation.particles)
    seed = 1000 * evaluation.scene_run.run + evaluation.repeat
    count = replace(config.adaptive_count, to_period=False)
    return replace(config, seed=seed, parallelism=1, adaptive_count=count)


def record(scene_run: SceneRun, code: str) -> bytes:
    """Simulates a run; returns its log, an MCAP file.

    Args:
        scene_run: which.
        code: evaluation_code of who asks.

    Raises:
        ValueError: the scene can't be recorded, or the code here is another.
    """
    _check_code(code)
    scene = load_run(scene_run)
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


def evaluate(evaluation: Evaluation, log: bytes, code: str) -> bytes:
    """Tracks a log and compares with its truth; returns a Result as JSON.

    Args:
        evaluation: what to evaluate.
        log: the MCAP file of its run.
        code: evaluation_code of who asks.

    Raises:
        ValueError: the log can't be tracked, or the code here is another.
    """
    _check_code(code)
    scene = LoadScene(scene_path(evaluation.scene_run.scene))
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
    """Returns what evaluate has made."""
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


def _check_code(code: str) -> None:
    if code != evaluation_code():
        raise ValueError(
            "the worker has other code, or another version of Python or of "
            "what is installed, than the program that asks; expected the same"
        )


def _read_log(data: bytes, scene: Scene, joint_names: tuple[str, ...]) -> Log:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        path.write_bytes(data)
        return ReadLog(filename=path, scene=scene, joint_names=joint_names)
