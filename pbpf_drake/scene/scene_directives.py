"""A scene's model directives, with files that Drake can read."""

import copy
from dataclasses import dataclass
from pathlib import Path

from pydrake.multibody.parsing import (
    FlattenModelDirectives,
    ModelDirective,
    ModelDirectives,
    PackageMap,
)

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.scene.model_files import ReadableModels
from pbpf_drake.scene.model_packages import ResolveModelUrl, SceneFolder


@dataclass
class ReadableDirectives:
    """A scene's directives as Drake can process them.

    Attributes:
        directives: all of them; every model's file is a file:// URL.
        models: the model files that were copied, and what was left out.
    """

    directives: list[ModelDirective]
    models: ReadableModels


def MakeReadable(scene: Scene, packages: PackageMap) -> ReadableDirectives:
    """Makes a scene's directives readable for Drake.

    Args:
        scene: its directives are left as they are.
        packages: where packages are.

    Raises:
        ValueError: a file is missing, or see ReadableModels.
    """
    folder = SceneFolder(scene)
    models = ReadableModels(packages)
    directives = []
    for directive in FlatDirectives(scene, packages):
        if directive.add_model is not None:
            model = directive.add_model
            try:
                path = ResolveModelUrl(model.file, folder, packages)
                if not path.is_file():
                    raise ValueError(f"{path} is no file; expected a model")
                readable = models.Make(path.absolute())
            except ValueError as error:
                message = f"add_model {model.name!r}: {error}"
                raise ValueError(message) from error
            directive = _with_file(directive, readable)
        directives.append(directive)
    return ReadableDirectives(directives, models)


def FlatDirectives(scene: Scene, packages: PackageMap) -> list[ModelDirective]:
    """Returns a scene's directives, with those of other files in their place.

    Args:
        scene: its directives are left as they are.
        packages: where packages are.

    Raises:
        ValueError: a file is missing.
    """
    directives, folder = scene.directives, SceneFolder(scene)
    if not any(d.add_directives for d in directives):
        return directives
    found = []
    for directive in directives:
        if directive.add_directives is not None:
            directive = copy.deepcopy(directive)
            file = directive.add_directives.file
            path = ResolveModelUrl(file, folder, packages)
            directive.add_directives.file = f"file://{path.absolute()}"
        found.append(directive)
    flat = FlattenModelDirectives(ModelDirectives(directives=found), packages)
    return flat.directives


def _with_file(directive: ModelDirective, path: Path) -> ModelDirective:
    changed = copy.deepcopy(directive)
    changed.add_model.file = f"file://{path}"
    return changed
