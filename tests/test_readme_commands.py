"""Every command of every README can be run as it stands there.

That is from the clone's root, where Python finds the clone's package before one
that is installed.
"""

from importlib.util import find_spec
import os
from pathlib import Path
import re
import shlex
import subprocess
import sys
import tomllib

from paths import DATA, ROOT
import pytest
from readmes import READMES, blocks, name_of, text_of

# What is added to each command so that it takes a few seconds at most and
# writes only to OUT, which is a temporary folder. An option that is given again
# replaces what the README has. "--help" shows that the command and its options
# exist. (.ci/run sets up environments, and runs more of the commands.)
ADDED = {
    # README.md
    "python3 -m venv .venv": "--help",
    ".venv/bin/pip install .": "--help",
    ".venv/bin/pbpf-track": "--method dope --out OUT",
    '.venv/bin/pip install ".[test]"': "--help",
    ".venv/bin/pytest": "--help",
    '.venv/bin/pip install ".[docs]"': "--help",
    "write_reference --output-directory reference": "--help",
    # pbpf_drake/log/README.md
    ".venv/bin/pbpf-track --inspect my.bag --scene my_scene.yaml": (
        "--inspect diagrams/logs/cheezit_1.mcap "
        "--scene diagrams/scenes/cheezit_1.yaml"
    ),
    ".venv/bin/pbpf-track --log THEIR.bag "
    "--scene diagrams/scenes/authors_cheezit_1.yaml": "--help",
    # pbpf_drake/filtering/README.md
    "filter_in_station": "",
    # diagrams/README.md
    "draw_camera_views --help": "",
    # diagrams/scenes/README.md
    ".venv/bin/pbpf-record --run 1 --out push_1.mcap": (
        "--duration 1 --out OUT/push_1.mcap"
    ),
    ".venv/bin/pbpf-track --log push_1.mcap --out push_1": "--help",
    "draw_scenes cheezit_1.mcap cheezit_2.mcap": "--help",
    "compare_detector FOLDER_OF_TRACES --runs 3": "--help",
    "compare_methods --seeds 10": "--methods dope --seeds 1 --out OUT",
    # diagrams/paper/README.md
    "reproduce_tables": "--help",
    '.venv/bin/pip install ".[cluster]"': "--help",
    ".venv/bin/dask scheduler --host 127.0.0.1": "--help",
    ".venv/bin/dask worker tcp://127.0.0.1:8786 --nworkers 8 --nthreads 1": (
        "--help"
    ),
    "reproduce_tables --scheduler tcp://127.0.0.1:8786": "--help",
    # diagrams/recorded_pushes/README.md
    "evaluate_pushes FOLDER_OF_CSV_FILES": "--seeds 1 --jobs 1 --out OUT",
    "evaluate_push_bags FOLDER_OF_BAGS --seeds 20": "--help",
    "evaluate_dropouts FOLDER_OF_CSV_FILES": "--help",
    # diagrams/closed_loop/README.md
    "closed_loop_push": "--help",
    # diagrams/benchmark/README.md
    "benchmark_update": (
        "--updates 2 --samples 1 --particles 5 --objects 1 --threads 1"
    ),
    '.venv/bin/pip install ".[peers]"': "--help",
    "benchmark_update --peers": "--help",
    "benchmark_update --endurance 2000 --particles 70 --objects 1 "
    "--threads 2": "--help",
    "benchmark_update --updates 12 --objects 3 --particles 150 --threads 2 "
    "--peers": "--help",
}
# How the README runs a module of diagrams; left out in the table above.
DIAGRAM = ".venv/bin/python -m pbpf_drake.diagrams."
# One recorded push, in the place of a FOLDER_OF_CSV_FILES.
PUSH = DATA / "real_pushes" / "StraightLine_2016_10_23_StraightLineOpenLoop.csv"


def commands() -> list[str]:
    """Every command of every README once, each in one line."""
    text = "\n".join(blocks("sh")).replace("\\\n", " ")
    found = [" ".join(c.split()) for c in re.split(r"&&|&|\n", text)]
    return list(dict.fromkeys(c.removeprefix(DIAGRAM) for c in found if c))


def arguments_of(command: str) -> list[str]:
    """The command for the Python that runs the tests, without an activation."""
    if not command.startswith((".venv/bin/", "python3 ")):
        command = DIAGRAM + command
    program, *arguments = shlex.split(command)
    name = program.removeprefix(".venv/bin/")
    if name in ("python", "python3"):
        return [sys.executable, *arguments]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    module = project["scripts"].get(name, name).removesuffix(":main")
    return [sys.executable, "-m", module, *arguments]


def run(arguments: list[str]) -> str:
    """What the command prints; it runs without this process's PYTHONPATH."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    done = subprocess.run(
        arguments,
        cwd=ROOT,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


def test_every_command_is_covered_and_no_other():
    assert set(commands()) == set(ADDED)


@pytest.mark.parametrize("readme", READMES, ids=name_of)
def test_commands_are_in_blocks(readme):
    code = re.findall(r"(?<!`)`([^`\n]+)`(?!`)", text_of(readme))
    program = r"(\.venv/bin/\S+|python3?|pip|dask|pbpf-\w+) \S"
    assert [c for c in code if re.match(program, c)] == []


@pytest.mark.parametrize("command", commands())
def test_command_runs_from_the_root_of_the_clone(command, tmp_path):
    arguments = arguments_of(command)
    if arguments[2] == "dask" and not find_spec("distributed"):
        pytest.skip("distributed isn't installed")
    added = ADDED[command].replace("OUT", str(tmp_path / "out")).split()
    if added == ["--help"]:
        text = run(arguments + added)
        for option in re.findall(r"--[\w-]+", command):
            assert option in text
        return
    if "FOLDER_OF_CSV_FILES" in arguments:
        if not PUSH.exists():
            pytest.skip(f"there are no recorded pushes in {DATA}")
        arguments[arguments.index("FOLDER_OF_CSV_FILES")] = folder(tmp_path)
    run(arguments + added)


def folder(tmp_path: Path) -> str:
    """A new folder with one recorded push."""
    (pushes := tmp_path / "pushes").mkdir()
    (pushes / PUSH.name).symlink_to(PUSH)
    return str(pushes)
