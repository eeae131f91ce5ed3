"""Refuses YAML files that would lose something, or never end, when read.

PyYAML keeps only the last of two equal keys, and follows an anchor that
contains itself for ever. So a file is looked through before it is read.
"""

from collections import Counter
from collections.abc import Iterator
import math
from pathlib import Path

import yaml

_MAX_BYTES = 10_000_000
# How deep a file is nested at most, and how many values it has, also where
# anchors repeat them.
_MAX_DEPTH = 50
_MAX_VALUES = 100_000
# Where models are is given in meters and radians: more can only be a mistake.
_MAX_NUMBER = 1e6
# So are all numbers in fields of these names.
_POSES = {"directives", "X_WC", "X_WR"}
_FLOAT = "tag:yaml.org,2002:float"
_INT = "tag:yaml.org,2002:int"


def RequireRegularFile(path: Path) -> None:
    """Raises a ValueError if a path is something that reading may not end with.

    Args:
        path: of a file. Where there is nothing, nothing is said.

    Raises:
        ValueError: it is a folder, a pipe, a device or a socket.
    """
    if path.exists() and not path.is_file():
        raise ValueError(
            f"{path} is no regular file; expected one: write what comes out of "
            "a pipe or a device to a file first"
        )


def CheckYamlFile(path: Path) -> None:
    """Raises a ValueError if a file isn't one plain YAML document.

    Args:
        path: of the file, which exists.

    Raises:
        ValueError: it is no regular file, is larger than 10 MB or no YAML, has
            a key twice, is nested too deeply, contains itself or becomes too
            large where anchors are put in, or a number in its directives or
            poses is out of range. The message names the field and the line,
            not the file.
    """
    RequireRegularFile(path)
    size = path.stat().st_size
    if size > _MAX_BYTES:
        raise ValueError(
            f"it has {size:,} bytes; expected at most {_MAX_BYTES:,}"
        )
    check_yaml(path.read_bytes())


def check_yaml(data: bytes) -> None:
    """Raises a ValueError as CheckYamlFile does, for what is in a file."""
    try:
        _check_depth(data)
        root = yaml.compose(data, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = f"line {mark.line + 1}: " if mark else ""
        raise ValueError(f"{line}{error.problem}; expected YAML") from error
    except (yaml.YAMLError, ValueError) as error:
        if type(error) is ValueError:
            raise
        text = str(error).replace("\n", " ")
        raise ValueError(f"it is no YAML: {text}") from error
    if root is not None:
        _Walk().Count(root, ())


def _check_depth(data: bytes) -> None:
    """Counts brackets without following any, as composing them recurses."""
    depth = 0
    for event in yaml.parse(data, Loader=yaml.SafeLoader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > _MAX_DEPTH:
            line = event.start_mark.line + 1
            raise ValueError(
                f"line {line} is nested more deeply than {_MAX_DEPTH} levels; "
                "expected fewer"
            )


class _Walk:
    """Goes through all values as a reader would, counting each once."""

    def __init__(self) -> None:
        self._counts: dict[int, int] = {}
        self._open: set[int] = set()

    def Count(self, node: yaml.Node, path: tuple[str, ...]) -> int:
        """Returns how many values a node has, those of anchors each time.

        Args:
            node: a part of the file.
            path: the names of the fields that it is in.
        """
        if id(node) in self._open:
            raise ValueError(
                f"{_name(path)} contains itself through its anchor in "
                f"{_line(node)}; expected its value"
            )
        if id(node) not in self._counts:
            _check_keys(node, path)
            _check_number(node, path)
            self._open.add(id(node))
            count = 1 + sum(self.Count(n, p) for n, p in _parts(node, path))
            self._open.remove(id(node))
            self._counts[id(node)] = count
        if len(path) > _MAX_DEPTH or self._counts[id(node)] > _MAX_VALUES:
            raise ValueError(
                f"{_name(path)} has more than {_MAX_VALUES:,} values, or more "
                f"than {_MAX_DEPTH} levels of them; expected fewer"
            )
        return self._counts[id(node)]


def _parts(
    node: yaml.Node, path: tuple[str, ...]
) -> Iterator[tuple[yaml.Node, tuple[str, ...]]]:
    """The nodes in a node, each with its path."""
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield key, path
            yield value, (*path, str(key.value))
    if isinstance(node, yaml.SequenceNode):
        for i, value in enumerate(node.value):
            yield value, (*path, f"[{i}]")


def _check_keys(node: yaml.Node, path: tuple[str, ...]) -> None:
    """Raises a ValueError if a mapping has a key twice."""
    if not isinstance(node, yaml.MappingNode):
        return
    keys = [k for k, _ in node.value if isinstance(k, yaml.ScalarNode)]
    counts = Counter(k.value for k in keys)
    for key in keys:
        if counts[key.value] > 1:
            lines = [_line(k) for k in keys if k.value == key.value]
            raise ValueError(
                f"{_name((*path, key.value))} is given more than once, in "
                f"{' and '.join(lines)}; expected once: merge them"
            )


def _check_number(node: yaml.Node, path: tuple[str, ...]) -> None:
    """Raises a ValueError if a number of a pose is out of range."""
    if _POSES.isdisjoint(path) or node.tag not in (_FLOAT, _INT):
        return
    try:
        value = float(yaml.safe_load(node.value))
    except (OverflowError, ValueError, TypeError):
        value = math.inf
    if not abs(value) <= _MAX_NUMBER:
        raise ValueError(
            f"{_name(path)} in {_line(node)} is {node.value[:60]}; expected a "
            f"number from -{_MAX_NUMBER:,.0f} to {_MAX_NUMBER:,.0f}"
        )


def _line(node: yaml.Node) -> str:
    return f"line {node.start_mark.line + 1}"


def _name(path: tuple[str, ...]) -> str:
    """Returns a field's name: directives[3].add_model.name."""
    return ".".join(path).replace(".[", "[") or "the file"
