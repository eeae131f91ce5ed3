"""A digest of the code that a result depends on.

It covers a module and all modules of this package that it imports, directly or
through others. Comments, docstrings and layout don't count.
"""

import ast
import functools
import hashlib
import importlib.metadata
import importlib.util
from pathlib import Path
import platform

_PACKAGE = "pbpf_drake"
# Packages whose other versions may give other results.
_DEPENDENCIES = ("drake", "numpy", "scipy", "mcap", "mcap-ros2-support")


@functools.cache
def code_digest(module: str) -> str:
    """Returns the digest of a module, what it imports, and the versions.

    Args:
        module: the full name of a module of this package.
    """
    digest = hashlib.sha256()
    for name, path in sorted(_imported(module).items()):
        digest.update(f"{name}:{_plain_code(path.read_text('utf-8'))}".encode())
    for package in _DEPENDENCIES:
        digest.update(
            f"{package}{importlib.metadata.version(package)}".encode()
        )
    digest.update(platform.machine().encode())
    return digest.hexdigest()


def _imported(module: str) -> dict[str, Path]:
    """Returns the files of all modules that a module needs, by their names."""
    found: dict[str, Path] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in found or not name.startswith(_PACKAGE + "."):
            continue
        spec = importlib.util.find_spec(name)
        if spec is None or not spec.origin:
            continue
        found[name] = Path(spec.origin)
        waiting += _imports(ast.parse(found[name].read_text("utf-8")))
    return found


def _imports(tree: ast.Module) -> list[str]:
    """Returns the names that are imported, some of which are modules."""
    names = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        if isinstance(node, ast.ImportFrom) and node.module:
            if node.module == _PACKAGE:
                names += [f"{_PACKAGE}.{alias.name}" for alias in node.names]
            names.append(node.module)
    return names


def _plain_code(source: str) -> str:
    """Returns code without what doesn't change what it does."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and _is_text(body[0]):
            del body[0]
    return ast.dump(tree)


def _is_text(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )
