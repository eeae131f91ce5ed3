"""A scene, and digests of all the files that it is read from."""

from collections.abc import Iterator
from dataclasses import dataclass
import hashlib
import json
from pathlib import Path
import re

from pydrake.common.yaml import yaml_load
from pydrake.multibody.parsing import (
    FlattenModelDirectives,
    ModelDirectives,
    PackageMap,
)

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.jobs.scene_run import scene_path
from pbpf_drake.scene.model_packages import ResolveModelUrl, SceneFolder
from pbpf_drake.scene.scene_models import MakePackageMap

# The endings of files that may refer to others, and how they do.
_TEXTS = (".sdf", ".urdf", ".xml")
_REFERENCE = re.compile(
    r"<uri>\s*([^<]+?)\s*</uri>|\bfile(?:name)?=[\"']([^\"']+)[\"']"
)


@dataclass(frozen=True)
class SceneFiles:
    """A scene as its files have it now.

    Attributes:
        scene: what they say.
        recorded_digest: covers all that a recording depends on.
        tracked_digest: covers all that tracking a log depends on, except for
            the filter's configuration.
    """

    scene: Scene
    recorded_digest: str
    tracked_digest: str


def ReadSceneFiles(scene: str) -> SceneFiles:
    """Reads a scene.

    Args:
        scene: the name of a scene of this package, or the path of a file.

    Raises:
        FileNotFoundError, ValueError: the scene, or a file that it names,
            isn't there or can't be used.
    """
    path = scene_path(scene)
    loaded = LoadScene(path)
    content = yaml_load(filename=str(path))
    try:
        models = _models_digest(loaded)
    except (ValueError, RuntimeError) as error:
        raise ValueError(f"Scene {path}: {error}") from error
    return SceneFiles(
        scene=loaded,
        recorded_digest=_digest(content, ("filter",), models),
        tracked_digest=_digest(content, ("filter", "recording"), models),
    )


def _digest(
    content: dict[str, object], without: tuple[str, ...], models: str
) -> str:
    kept = {key: x for key, x in content.items() if key not in without}
    text = json.dumps(kept, sort_keys=True) + models
    return hashlib.sha256(text.encode()).hexdigest()


def _models_digest(scene: Scene) -> str:
    """Returns the digest of all files that may say what the models are.

    These are the files of the models, the files that these refer to, and all
    files in the same folders, except for scenes.
    """
    packages, home = MakePackageMap(scene), SceneFolder(scene)
    flat = FlattenModelDirectives(
        ModelDirectives(directives=scene.directives), packages
    )
    # The flat directives include those of files that the scene's refer to.
    digest = hashlib.sha256(str(flat.directives).encode())
    waiting = [
        ResolveModelUrl(directive.add_model.file, home, packages).parent
        for directive in flat.directives
        if directive.add_model is not None
    ]
    folders: set[Path] = set()
    while waiting:
        folder = waiting.pop().resolve()
        if folder in folders:
            continue
        folders.add(folder)
        for file in _files(folder):
            if file.suffix in _TEXTS:
                waiting += _references(file, packages)
    for folder in sorted(folders):
        for file in _files(folder):
            digest.update(f"{file.name}:".encode() + file.read_bytes())
    return digest.hexdigest()


def _files(folder: Path) -> list[Path]:
    return sorted(
        file
        for file in folder.iterdir()
        if file.is_file() and file.suffix != ".yaml"
    )


def _references(file: Path, packages: PackageMap) -> Iterator[Path]:
    """Yields the folders of the files that a model's file refers to."""
    for groups in _REFERENCE.findall(file.read_text(errors="replace")):
        name = "".join(groups)
        try:
            path = ResolveModelUrl(name, file.parent, packages)
        except ValueError:  # It is said when the model is loaded.
            continue
        yield path if path.is_dir() else path.parent
