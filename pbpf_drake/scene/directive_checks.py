"""Looks through the files that a scene's directives name, before Drake does.

Drake follows a file that includes itself until its process crashes, and waits
for ever where a file is a pipe.
"""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
import re

from pydrake.common.yaml import yaml_load
from pydrake.multibody.parsing import ModelDirective, PackageMap

from pbpf_drake.config.yaml_checks import CheckYamlFile, RequireRegularFile

# So many files, each as often as it is included, make up one scene at most.
_MAX_FILES = 10_000
_MAX_BYTES = 100_000_000
_DIRECTIVE_ENDINGS = (".yaml", ".yml")
# Models in these formats are text that may name further files.
_MODEL_ENDINGS = (".sdf", ".urdf", ".xml", ".mjcf", ".world", ".config")
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
# In SDF, a file's name is in an element; elsewhere, in an attribute.
_FILE_NAME = re.compile(
    r"<(?:uri|sdf)\b[^>]*>\s*([^<]+?)\s*</"
    r"|\b(?:filename|file)\s*=\s*[\"']([^\"']+)[\"']"
)


def CheckDirectiveFiles(
    directives: Sequence[ModelDirective], packages: PackageMap, folder: Path
) -> None:
    """Raises a ValueError if Drake would not come to an end with a file.

    A file that doesn't exist is left to Drake, which says so.

    Args:
        directives: of a scene.
        packages: where package:// leads to.
        folder: that of the scene file.

    Raises:
        ValueError: a file, or one that it names, includes itself, is no regular
            file, or isn't YAML as CheckYamlFile wants it; or there are more
            than 10,000 files.
    """
    walk = _Walk(packages)
    for directive in directives:
        for part in directive.add_model, directive.add_directives:
            if part is not None:
                walk.Follow(part.file, folder, ())


class _Walk:
    """Follows the names of files in files."""

    def __init__(self, packages: PackageMap):
        self._packages = packages
        self._num_files = 0
        self._names: dict[Path, tuple[str, ...]] = {}

    def Follow(self, name: str, folder: Path, above: tuple[Path, ...]) -> None:
        """Looks through one file and what it names.

        Args:
            name: of the file, as it is written somewhere.
            folder: of the file that has this name.
            above: the files that have led here, from the first on.
        """
        path = self._Find(name, folder)
        if path is None:
            return
        RequireRegularFile(path)
        if path in above:
            way = " → ".join(p.name for p in (*above, path))
            raise ValueError(
                f"{path} includes itself ({way}); remove one of these includes"
            )
        self._num_files += 1
        if self._num_files > _MAX_FILES:
            raise ValueError(
                f"more than {_MAX_FILES:,} files are included, {path} the last "
                "of them; expected fewer"
            )
        if path not in self._names:
            self._names[path] = tuple(_names_in(path))
        for found in self._names[path]:
            self.Follow(found, path.parent, (*above, path))

    def _Find(self, name: str, folder: Path) -> Path | None:
        """Returns the file that is meant; None if there is none."""
        if "://" in name:
            try:
                path = Path(self._packages.ResolveUrl(_as_package(name)))
            except RuntimeError:
                return None
        else:
            path = folder / name
        if path.is_dir():
            path = path / "model.config"
        return path.resolve() if path.exists() else None


def _as_package(name: str) -> str:
    """Returns a URL in which model:// is package://, as Drake sees it."""
    return re.sub(r"^model://", "package://", name)


def _names_in(path: Path) -> Iterator[str]:
    """The names of the files that a file includes, or shows."""
    ending = path.suffix.lower()
    readers: dict[str, Callable[[Path], Iterator[str]]] = {
        **dict.fromkeys(_DIRECTIVE_ENDINGS, _names_in_directives),
        **dict.fromkeys(_MODEL_ENDINGS, _names_in_model),
    }
    if ending in readers:
        yield from readers[ending](path)


def _names_in_directives(path: Path) -> Iterator[str]:
    try:
        CheckYamlFile(path)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    data = yaml_load(filename=str(path))
    directives = data.get("directives") if isinstance(data, dict) else None
    for directive in directives if isinstance(directives, list) else ():
        for part in "add_model", "add_directives":
            value = isinstance(directive, dict) and directive.get(part)
            if isinstance(value, dict) and isinstance(value.get("file"), str):
                yield value["file"]


def _names_in_model(path: Path) -> Iterator[str]:
    if path.stat().st_size > _MAX_BYTES:
        raise ValueError(
            f"{path} has {path.stat().st_size:,} bytes; expected at most "
            f"{_MAX_BYTES:,}"
        )
    text = path.read_text(encoding="utf-8", errors="replace")
    for match in _FILE_NAME.finditer(_COMMENT.sub("", text)):
        yield match[1] or match[2]
