"""What Drake would not come to an end with is refused in a sentence."""

import os
import subprocess
import sys

from filter_fixtures import PLANAR_SCENE
import pytest

# In a process of its own: where a check is missing, it crashes or hangs.
_LOAD = """
import sys
from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.scene.prediction_model import MakePredictionModel
try:
    MakePredictionModel(LoadScene(sys.argv[1]))
except ValueError as error:
    print(error)
"""
_ADD = "\n- {add}\nrobot: pusher"
_MODEL = "add_model: {name: own, file: %s}"
_INCLUDE = "add_directives: {file: %s}"
_FIXED = "<sdf version='1.9'><model name='m'><static>1</static>%s</model></sdf>"


def _load(tmp_path, add: str, files: dict[str, str | None]) -> str:
    """Returns what is said of a scene with one more directive."""
    for name, text in files.items():
        if text is None:
            os.mkfifo(tmp_path / name)
        else:
            (tmp_path / name).write_text(text)
    scene = tmp_path / "my_scene.yaml"
    more = _ADD.format(add=add)
    scene.write_text(PLANAR_SCENE.replace("\nrobot: pusher", more))
    result = subprocess.run(
        [sys.executable, "-c", _LOAD, str(scene)],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.count("\n") <= 1
    return result.stdout


def _dmd(*names: str) -> str:
    lines = [f"- add_directives: {{file: package://scene/{n}}}" for n in names]
    return "\n".join(["directives:", *lines]) + "\n"


@pytest.mark.parametrize(
    "add, files, way",
    [
        (_INCLUDE, {"a.dmd.yaml": _dmd("a.dmd.yaml")}, "a.dmd.yaml → a.dmd.y"),
        (
            _INCLUDE,
            {"a.dmd.yaml": _dmd("b.yaml"), "b.yaml": _dmd("a.dmd.yaml")},
            "a.dmd.yaml → b.yaml → a.dmd.yaml",
        ),
        (
            _MODEL,
            {
                "a.sdf": _FIXED
                % "<include><uri>package://scene/a.sdf</uri></include>"
            },
            "a.sdf → a.sdf",
        ),
        (
            _MODEL,
            {"a.xml": "<mujoco><include file='a.xml'/></mujoco>"},
            "a.xml → a.xml",
        ),
    ],
)
def test_a_file_that_includes_itself_is_refused_with_the_way(
    tmp_path, add, files, way
):
    first = tmp_path / next(iter(files))
    said = _load(tmp_path, add % f"package://scene/{first.name}", files)
    assert f"my_scene.yaml: {first} includes itself ({way}" in said


@pytest.mark.parametrize(
    "add, name, text",
    [
        (_MODEL, "pipe.urdf", ""),
        (_MODEL, "pipe.obj", ""),
        (_INCLUDE, "pipe.yaml", ""),
        (
            _MODEL,
            "a.sdf",
            _FIXED % "<link name='l'><visual name='v'><geometry><mesh>"
            "<uri>pipe.obj</uri></mesh></geometry></visual></link>",
        ),
    ],
)
def test_a_pipe_is_refused_without_waiting_for_it(tmp_path, add, name, text):
    files = {name: text, "pipe.obj": None} if text else {name: None}
    said = _load(tmp_path, add % f"package://scene/{name}", files)
    pipe = list(files)[-1]
    assert f"{tmp_path / pipe} is no regular file; expected one" in said


@pytest.mark.parametrize(
    "text, message",
    [
        ("directives: &d [*d]\n", "directives[0] contains itself"),
        ("directives: []\ndirectives: []\n", "directives is given more than"),
        (
            "directives:\n- add_weld: {X_PC: {translation: [.nan, 0, 0]}}\n",
            "translation[0] in line 2 is .nan; expected a number from",
        ),
    ],
)
def test_an_included_file_is_checked_as_a_scene_file_is(
    tmp_path, text, message
):
    said = _load(
        tmp_path, _INCLUDE % "package://scene/a.yaml", {"a.yaml": text}
    )
    assert f"{tmp_path / 'a.yaml'}: " in said and message in said


def test_includes_that_multiply_each_other_are_refused(tmp_path):
    files = {f"{i}.yaml": _dmd(*[f"{i + 1}.yaml"] * 10) for i in range(8)}
    files["8.yaml"] = "directives: []\n"
    said = _load(tmp_path, _INCLUDE % "package://scene/0.yaml", files)
    assert "more than 10,000 files are included" in said


def test_a_file_may_be_included_twice(tmp_path):
    files = {
        "a.yaml": _dmd("b.yaml", "b.yaml"),
        "b.yaml": "directives: []\n",
    }
    assert _load(tmp_path, _INCLUDE % "package://scene/a.yaml", files) == ""


@pytest.mark.parametrize("name", ["none.sdf", "http://scene/a.sdf"])
def test_a_file_that_is_missing_is_left_to_drake(tmp_path, name):
    name = name if ":" in name else f"package://scene/{name}"
    assert name.rpartition("/")[2] in _load(tmp_path, _MODEL % name, {})
