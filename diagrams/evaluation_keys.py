"""The keys of recorded logs and of results: all that they depend on."""

from dataclasses import asdict
import functools
import hashlib
import json
from pathlib import Path
from typing import Any

from pydrake.common.yaml import yaml_load

from pbpf_drake.diagrams.code_digest import code_digest
from pbpf_drake.diagrams.evaluation import (
    Evaluation,
    SceneRun,
    evaluation_code,
    evaluation_config,
    scene_path,
)
from pbpf_drake.scene import LoadScene, Scene
from pbpf_drake.scene_models import MakePackageMap


def recording_key(scene_run: SceneRun) -> dict[str, Any]:
    """Returns all that a recorded log depends on."""
    return {
        "scene": _scene_digest(scene_run.scene, without=("filter",)),
        "run": scene_run.run,
        "duration": scene_run.duration,
        "code": code_digest("pbpf_drake.truth_simulation")
        + code_digest("pbpf_drake.mcap_log_writer"),
    }


def evaluation_key(evaluation: Evaluation, log: bytes) -> dict[str, Any]:
    """Returns all that a result depends on."""
    scene = _load_scene(evaluation.scene_run.scene)
    config = asdict(evaluation_config(evaluation, scene))
    # Results don't depend on it.
    del config["parallelism"]
    return {
        "scene": _scene_digest(
            evaluation.scene_run.scene, without=("filter", "recording")
        ),
        "log": hashlib.sha256(log).hexdigest(),
        "method": evaluation.method,
        "config": config,
        "code": evaluation_code(),
    }


@functools.cache
def _load_scene(scene: str) -> Scene:
    """Returns a scene that is only looked at."""
    return LoadScene(scene_path(scene))


@functools.cache
def _scene_digest(scene: str, *, without: tuple[str, ...]) -> str:
    """Returns the digest of a scene's file and of its models' files."""
    path = scene_path(scene)
    content = yaml_load(filename=str(path))
    for section in without:
        content.pop(section, None)
    digest = hashlib.sha256(json.dumps(content, sort_keys=True).encode())
    packages = MakePackageMap(LoadScene(path))
    folders = {
        Path(packages.ResolveUrl(value["file"])).parent
        for directive in content["directives"]
        for value in directive.values()
        if "file" in value
    }
    for folder in sorted(folders):
        for file in sorted(folder.iterdir()):
            # Other scenes may lie beside a model.
            if file.is_file() and file.suffix != ".yaml":
                digest.update(f"{file.name}:".encode() + file.read_bytes())
    return digest.hexdigest()
