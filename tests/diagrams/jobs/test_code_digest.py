import importlib
from pathlib import Path
import sys

import pytest

from pbpf_drake.diagrams.jobs import code_digest as dut


@pytest.fixture
def digest(tmp_path, monkeypatch):
    """Returns the digest of module a, which imports b, of a small package."""
    package = tmp_path / "small_package"
    package.mkdir()
    (package / "__init__.py").touch()
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(dut, "_PACKAGE", "small_package")

    def compute(**sources: str) -> str:
        for name, source in sources.items():
            (package / f"{name}.py").write_text(source)
        importlib.invalidate_caches()
        dut.code_digest.cache_clear()
        return dut.code_digest("small_package.a")

    yield compute
    dut.code_digest.cache_clear()
    for name in [n for n in sys.modules if n.startswith("small_package")]:
        del sys.modules[name]


A = "from small_package.b import f\n\n\ndef g(x):\n    return f(x)\n"
B = "def f(x):\n    return x + 1\n"


def test_it_changes_with_the_code_of_what_is_imported(digest):
    first = digest(a=A, b=B, c="import os\n")
    assert digest(b=B.replace("1", "2")) != first
    assert digest(b=B) == first
    assert digest(a=A.replace("f(x)", "f(f(x))")) != first


def test_it_follows_imports_of_modules_from_the_package(digest):
    a = "from small_package import b\n"
    assert digest(a=a, b=B) != digest(b=B + "\n\ny = 3\n")


def test_comments_docstrings_and_layout_do_not_count(digest):
    first = digest(a=A, b=B)
    b = """'Adds.'

# One more.
def f(x):
    'Adds one.'
    return (x
            + 1)
"""
    assert digest(a=f"'A.'\n{A}", b=b) == first


def test_what_is_not_imported_does_not_count(digest):
    first = digest(a=A, b=B, c="x = 1\n")
    assert digest(c="x = 2\n") == first


def test_versions_of_what_computes_count(digest, monkeypatch):
    first = digest(a=A, b=B)
    monkeypatch.setattr(dut.importlib.metadata, "version", lambda _: "99")
    assert digest() != first


def _needed(name: str) -> set[str]:
    """The last names of the modules that one of this package's needs."""
    found = dut._imported(f"pbpf_drake.{name}")
    return {n.rpartition(".")[2] for n in found}


def test_the_evaluation_depends_on_the_filter_but_not_on_the_pictures():
    name = "pbpf_drake.diagrams.paper.evaluation"
    found = _needed("diagrams.paper.evaluation")
    assert {
        "particle_filter_update",
        "physics_motion_model",
        "pose_metrics",
        "log_reader",
        "scene_config",
        "quaternions",
        "evaluation",
    } <= found
    assert not {"error_plot", "report", "paper_tables"} & found
    assert (
        Path(dut._imported(name)["pbpf_drake.config.scene_config"]).name
        == "scene_config.py"
    )


def test_a_recording_depends_on_the_truth_but_not_on_the_filter():
    found = _needed("diagrams.jobs.scene_recording")
    assert {
        "truth_simulation",
        "simulated_detector",
        "mcap_log_writer",
        "scene_recording",
    } <= found
    assert "particle_filter_update" not in found
