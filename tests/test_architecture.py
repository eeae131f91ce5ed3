"""Which room may import from which; the table is the architecture."""

import ast
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

from paths import ROOT
import pytest

PACKAGE = ROOT / "pbpf_drake"
# Modules that lie in no room, and rotations, are for everybody.
FOR_ALL = {"root", "poses"}
MAY_IMPORT = {
    "root": set(),
    "poses": set(),
    "config": set(),
    "shapes": set(),
    "bags": set(),
    "scene": {"config", "shapes"},
    "log": {"bags", "config"},
    "motion": {"scene", "shapes", "config"},
    "visibility": {"scene", "shapes", "config"},
    "filtering": {"motion", "visibility", "scene", "config"},
    # Never from or to the filter: nobody grades themselves.
    "truth": {"log", "scene", "config"},
    "results": {"log", "motion", "visibility", "config"},
    "views": {"log", "bags", "scene", "shapes", "config"},
    "tracking": {"views", "results", "filtering", "log", "scene", "config"},
}


def _modules() -> Iterator[tuple[str, Path]]:
    """Every module of the package with its room."""
    for file in sorted(PACKAGE.rglob("*.py")):
        parts = file.relative_to(PACKAGE).parts
        if parts != ("__init__.py",):
            yield (parts[0] if len(parts) > 1 else "root"), file


def _imported(file: Path) -> Iterator[str]:
    """The full names of what a module imports."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        if isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def _room(name: str) -> str | None:
    """The room that an imported name is from; None if it isn't ours."""
    first, *rest = name.split(".")
    if first != PACKAGE.name:
        return None
    return rest[0] if rest and (PACKAGE / rest[0]).is_dir() else "root"


@pytest.mark.parametrize(
    "room, file", list(_modules()), ids=lambda x: getattr(x, "stem", x)
)
def test_rooms_import_only_what_they_may(room, file):
    rooms = {_room(name) for name in _imported(file)} - {None, room}
    assert rooms <= MAY_IMPORT[room] | FOR_ALL


def test_there_is_no_cycle_of_rooms():
    reached: set[str] = set()
    while ready := {
        room
        for room, rooms in MAY_IMPORT.items()
        if room not in reached and rooms <= reached
    }:
        reached |= ready
    assert reached == set(MAY_IMPORT)


def test_reading_bags_needs_no_drake():
    for room, file in _modules():
        if room == "bags":
            assert not any(x.startswith("pydrake") for x in _imported(file))


def test_there_is_no_cycle_of_modules():
    """TopologicalSorter raises a CycleError that names one."""
    graph: dict[str, set[str]] = {}
    for _, file in _modules():
        name = ".".join(file.relative_to(ROOT).with_suffix("").parts)
        graph[name.removesuffix(".__init__")] = set(_imported(file))
    modules = {
        name: {m for m in graph if m in imported or _is_part(m, imported)}
        for name, imported in graph.items()
    }
    assert len(list(TopologicalSorter(modules).static_order())) == len(graph)


def _is_part(module: str, imported: set[str]) -> bool:
    """Whether something of a module is imported."""
    return any(name.rpartition(".")[0] == module for name in imported)
