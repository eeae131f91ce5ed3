"""Writes the reference of all public names as HTML, from the docstrings.

It needs Sphinx: ``pip install "pbpf_drake[docs]"``. Whatever Sphinx warns of is
an error.
"""

import argparse
import importlib
import inspect
from pathlib import Path
import re
import sys
import tempfile
from typing import Any

from pbpf_drake.diagrams.jobs.run_command import RunCommand

# Of this module, which is the extension of Sphinx as well.
_NAME = "pbpf_drake.diagrams.write_reference"
_SETTINGS = {
    "project": "pbpf_drake",
    "extensions": ["sphinx.ext.autodoc", "sphinx.ext.napoleon", _NAME],
    "autodoc_member_order": "bysource",
    # What Drake's own classes say is in Drake's reference.
    "autodoc_inherit_docstrings": False,
    "napoleon_use_ivar": True,
    "python_maximum_signature_line_length": 80,
    "html_theme": "alabaster",
    "html_copy_source": False,
}
# All of __all__.
_PAGE = """\
pbpf_drake
==========

.. automodule:: pbpf_drake
   :members:
   :imported-members:
"""
_FIELD = re.compile(r"    (\w+): ")
_COMMENT = "    # "


def write_sources(folder: Path) -> None:
    """Writes what Sphinx starts from: its settings and a page to fill."""
    settings = "".join(f"{name} = {x!r}\n" for name, x in _SETTINGS.items())
    (folder / "conf.py").write_text(settings, encoding="utf-8")
    (folder / "index.rst").write_text(_PAGE, encoding="utf-8")


def show_ports(lines: list[str]) -> list[str]:
    """Returns the lines of a docstring with Drake's own block as YAML."""
    return [
        line.replace(".. pydrake_system::", ".. code-block:: yaml")
        for line in lines
    ]


def field_comments(source: str) -> dict[str, str]:
    """Returns what the comments above the fields of a dataclass say.

    Args:
        source: of the class.
    """
    comments: dict[str, str] = {}
    said: list[str] = []
    for line in source.splitlines():
        field = _FIELD.match(line)
        if field and said:
            comments[field.group(1)] = " ".join(said)
        is_comment = line.startswith(_COMMENT)
        said = [*said, line.removeprefix(_COMMENT)] if is_comment else []
    return comments


def _list_fields(value: type) -> list[str]:
    """Returns the fields of a dataclass as a section of its docstring."""
    comments = field_comments(inspect.getsource(value))
    if not comments:
        return []
    fields = [f"    {name}: {text}" for name, text in comments.items()]
    return ["", "Attributes:", *fields, ""]


def _process_docstring(
    app: Any, kind: str, name: str, value: Any, options: Any, lines: list[str]
) -> None:
    lines[:] = show_ports(lines)
    if hasattr(value, "__dataclass_fields__"):
        lines += _list_fields(value)


def setup(app: Any) -> dict[str, bool]:
    """Makes this module an extension of Sphinx; it calls this."""
    # Before the extension napoleon, which reads the sections.
    app.connect("autodoc-process-docstring", _process_docstring, priority=400)
    return {"parallel_read_safe": True}


def run(args: argparse.Namespace) -> None:
    """Builds the reference, and says where it is."""
    try:
        build = importlib.import_module("sphinx.cmd.build").build_main
    except ModuleNotFoundError as error:
        raise ValueError(
            "Sphinx is not installed; expected pip install 'pbpf_drake[docs]'"
        ) from error
    with tempfile.TemporaryDirectory() as folder:
        write_sources(Path(folder))
        options = ["-W", "--keep-going", "-q", "-d", f"{folder}/.cache"]
        if build([*options, folder, str(args.output_directory)]):
            raise ValueError("the docstrings have the errors above")
    print(f"Written to {args.output_directory / 'index.html'}")


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--output-directory", type=Path, required=True)
    args = parser.parse_args(argv)
    return RunCommand("write_reference", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
