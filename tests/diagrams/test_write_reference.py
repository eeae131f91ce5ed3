"""The API reference is whole and is built without any warning."""

from pathlib import Path
import re
import subprocess
import sys

import pytest

import pbpf_drake
from pbpf_drake.diagrams import write_reference
from pbpf_drake.diagrams.write_reference import field_comments, show_ports

_COMMAND = [sys.executable, "-P", "-m", write_reference.__name__]
_BROKEN = """
import sys
import pbpf_drake
from pbpf_drake.diagrams.write_reference import main
pbpf_drake.ReadLog.__doc__ = "Reads *what the filter needs."
sys.exit(main(["--output-directory", sys.argv[1]]))
"""


def _run(*command: str | Path) -> subprocess.CompletedProcess:
    pytest.importorskip("sphinx", reason="needs the extra 'docs'")
    return subprocess.run(command, capture_output=True, text=True)


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> str:
    """The page of all public names."""
    folder = tmp_path_factory.mktemp("reference") / "new"
    done = _run(*_COMMAND, "--output-directory", folder)
    assert (done.returncode, done.stderr) == (0, "")
    return (folder / "index.html").read_text(encoding="utf-8")


def test_every_public_name_is_in_the_reference(page):
    missing = [
        name
        for name in pbpf_drake.__all__
        if f'id="pbpf_drake.{name}"' not in page
    ]
    assert missing == []


def test_ports_of_systems_are_blocks_of_yaml(page):
    systems = [
        name
        for name in pbpf_drake.__all__
        if ".. pydrake_system::" in (getattr(pbpf_drake, name).__doc__ or "")
    ]
    assert len(systems) >= 7
    assert page.count('class="highlight-yaml') == len(systems)
    assert "pydrake_system" not in page


def test_fields_of_the_configuration_are_explained(page):
    text = re.sub("<[^>]+>", "", page)
    assert "period (float) – Δt, the time between two updates" in text


def test_a_docstring_that_is_not_sound_is_an_error(tmp_path):
    done = _run(sys.executable, "-P", "-c", _BROKEN, tmp_path)
    assert done.returncode == 1
    assert "pbpf_drake.log.log_reader.ReadLog" in done.stderr
    assert "start-string without end-string" in done.stderr


def test_drakes_block_of_ports_becomes_yaml():
    lines = ["Adds.", "", ".. pydrake_system::", "", "    name: Adder"]
    shown = show_ports(lines)
    assert shown[2] == ".. code-block:: yaml"
    assert shown[:2] + shown[3:] == lines[:2] + lines[3:]


def test_comments_above_fields_are_what_they_say():
    source = '''class Config:
    """A text."""

    # How long
    # it takes.
    time: float = 1.0
    unexplained: int = 2
    # Of no field.

    other: str = ""

    def method(self) -> None:
        # Nor this.
        value: int = 3
'''
    assert field_comments(source) == {"time": "How long it takes."}
