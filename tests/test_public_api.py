"""The package as a user sees it."""

import inspect
import re
import subprocess
import sys
import textwrap
import time

import pytest

import pbpf_drake


@pytest.mark.parametrize("name", pbpf_drake.__all__)
def test_public_names_are_documented_and_from_this_package(name):
    value = getattr(pbpf_drake, name)
    assert value.__module__.startswith("pbpf_drake.")
    assert inspect.getdoc(value), name


def test_public_names_are_sorted_and_complete():
    names = pbpf_drake.__all__
    assert names == sorted(set(names))
    imported = {
        name
        for name, value in vars(pbpf_drake).items()
        if not name.startswith("_") and not inspect.ismodule(value)
    }
    assert imported == set(names)


def test_example_in_the_documentation_runs(capsys):
    text = re.search(r"::\n\n((?:    .*\n|\n)+)", pbpf_drake.__doc__).group(1)
    exec(compile(textwrap.dedent(text), "pbpf_drake", "exec"), {})
    assert "cracker" in capsys.readouterr().out


def test_import_takes_little_longer_than_that_of_drake():
    """As a ratio: how fast the machine is, and what else it does, differs."""
    code = "import pbpf_drake, sys; print(*sys.modules)"
    run = [sys.executable, "-P", "-c", code]
    loaded = subprocess.run(run, check=True, capture_output=True, text=True)
    others = [m for m in loaded.stdout.split() if m.startswith("pydrake.")]
    programs = [
        "import pbpf_drake",
        "import numpy, cv2, " + ", ".join(others),
    ]
    seconds: list[list[float]] = [[], []]
    for _ in range(4):
        for program, times in zip(programs, seconds, strict=True):
            start = time.perf_counter()
            subprocess.run([sys.executable, "-P", "-c", program], check=True)
            times.append(time.perf_counter() - start)
    ours, drakes = map(min, seconds)
    assert ours < 5 * drakes


def test_import_leaves_out_what_is_slow_to_import():
    code = "import pbpf_drake, sys; print(*sys.modules)"
    run = subprocess.run(
        [sys.executable, "-P", "-c", code],
        check=True,
        capture_output=True,
        text=True,
    )
    assert not {"matplotlib", "scipy", "pydrake.all"} & set(run.stdout.split())
