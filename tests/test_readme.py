"""What the READMEs say, against the code."""

from importlib import import_module
import inspect
import pkgutil
import re

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
import pytest
from readmes import blocks, rows

import pbpf_drake
from pbpf_drake import (
    AddSceneModels,
    LoadScene,
    ParticleFilterConfig,
    ReadLog,
    VisibilityConfig,
)
from pbpf_drake.diagrams import reproduce_tables, track_log
from pbpf_drake.log.pose_interpolation import interpolate_poses


def run(code: str) -> dict:
    namespace = {"__name__": "__main__"}
    exec(compile(code, "README.md", "exec"), namespace)
    return namespace


def test_every_block_of_python_is_run_below():
    names = "DiagramBuilder()", "LiveFilter", "WriteLog"
    for block in blocks("python"):
        assert sum(name in block for name in names) == 1


def test_filter_in_a_diagram_of_ones_own_finds_the_object(capsys):
    code = next(b for b in blocks("python") if "DiagramBuilder()" in b)
    assert len(code.splitlines()) <= 30
    found = run(code)
    assert "cracker box is at" in capsys.readouterr().out
    # The last update before 2.5 s.
    _, truth = interpolate_poses(
        found["log"].ground_truth["cracker"], np.array([2.4])
    )
    error = np.linalg.norm(found["X_WO"].translation() - truth[0])
    assert error < 0.04


def test_filter_is_updated_by_hand(capsys):
    code = next(b for b in blocks("python") if "LiveFilter" in b)
    found = run(code)
    assert "block is at" in capsys.readouterr().out
    # Nothing is detected, so it is where the scene has it.
    np.testing.assert_allclose(
        found["X_WO"].translation(), [0.2, 0.0, 0.0065], atol=1e-12
    )


def test_log_of_ones_own_is_written_and_can_be_read(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code = next(b for b in blocks("python") if "WriteLog" in b)
    written = run(code)
    log = ReadLog(
        filename="push.mcap",
        scene=written["scene"],
        joint_names=["pusher_x", "pusher_y"],
    )
    assert log.warnings == ()
    np.testing.assert_array_equal(
        log.joints.positions, written["log"].joints.positions
    )
    (detection,) = log.detections
    assert detection.name == "block" and detection.received == 0.08


def test_scene_with_an_object_of_ones_own_loads(tmp_path, monkeypatch):
    (yaml,), (sdf,) = blocks("yaml"), blocks("xml")
    (tmp_path / "my_scene.yaml").write_text(yaml)
    (tmp_path / "mug.sdf").write_text(sdf)
    scene = LoadScene(tmp_path / "my_scene.yaml")
    models = AddSceneModels(plant := MultibodyPlant(0.0), scene)
    (mug,) = models.objects
    assert plant.get_body(mug).name() == "mug"
    assert scene.object_by_class() == {"red_mug": "mug"}
    assert scene.filter == ParticleFilterConfig(), "said to be the defaults"
    soup = VisibilityConfig(
        high_weight=0.6,
        low_weight=0.45,
        high_visibility=0.8,
        low_visibility=0.9,
        penalty=0.33,
    )
    assert scene.tracked["mug"].visibility == soup


def test_example_scene_has_every_field_of_the_filter():
    (yaml,) = blocks("yaml")
    for name in vars(ParticleFilterConfig()):
        assert re.search(rf"^  {name}:", yaml, re.MULTILINE), name


def test_options_are_those_of_the_command(capsys):
    with pytest.raises(SystemExit):
        track_log.main(["--help"])
    options = set(re.findall(r"--\w+", capsys.readouterr().out)) - {"--help"}
    named = {re.search(r"--\w+", row[0]).group() for row in rows("option")}
    assert named == options


def test_arguments_are_those_of_the_command_that_reproduces_the_tables(capsys):
    with pytest.raises(SystemExit):
        reproduce_tables.main(["--help"])
    options = set(re.findall(r"--[a-z]+", capsys.readouterr().out))
    named = {
        n for row in rows("argument") for n in re.findall(r"--\w+", row[0])
    }
    assert named == options - {"--help"}


def test_ports_are_those_of_the_systems():
    table = rows("system")
    assert len(table) == 7
    for name, inputs, outputs in table:
        system = getattr(pbpf_drake, name.strip("`"))
        text = inspect.getdoc(system)
        for title, cell in ("input_ports", inputs), ("output_ports", outputs):
            block = re.search(rf"{title}:\n((?: *- .*\n)+)", text)
            ports = re.findall(r"- (.*)", block.group(1)) if block else []
            said = [p.replace("`", "") for p in cell.split(", ") if p]
            assert said == ports, (name, title)


def test_every_port_is_explained():
    explained = {p for row in rows("port") for p in re.findall(r"\w+", row[0])}
    for _, inputs, outputs in rows("system"):
        ports = re.findall(r"`(\w+)`", inputs + outputs)
        assert set(ports) <= explained


def test_code_that_is_named_beside_the_paper_exists():
    table = rows("paper")
    assert len(table) > 10
    modules = {
        info.name.rpartition(".")[2]: info.name
        for info in pkgutil.walk_packages(pbpf_drake.__path__, "pbpf_drake.")
    }
    for row in table:
        names = re.findall(r"`(\w+)\.(\w+)`", row[-1])
        assert names, row
        for module, name in names:
            assert hasattr(import_module(modules[module]), name), name
