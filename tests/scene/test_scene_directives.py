"""How a scene names its models' files."""

import os

from mesh_fixtures import write_gantry, write_gantry_scene, write_mesh
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.scene.prediction_model import MakePredictionModel


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def robots(tmp_path):
    """A folder with a gantry of STL, in a package of its own."""
    folder = tmp_path / "ws" / "share" / "gantry_description"
    folder.mkdir(parents=True)
    write_mesh(folder / "wedge.stl")
    url = "package://gantry_description/wedge.stl"
    write_gantry(folder / "gantry.urdf", collision=url)
    return folder


def _links(scene):
    return len(MakePredictionModel(LoadScene(scene)).links)


@pytest.mark.parametrize(
    "file",
    [
        "{folder}/gantry.urdf",
        "file://{folder}/gantry.urdf",
        "ws/share/gantry_description/gantry.urdf",
        "./ws/share/gantry_description/gantry.urdf",
        "package://scene/ws/share/gantry_description/gantry.urdf",
    ],
)
def test_a_model_may_be_named_by_url_or_path(tmp_path, robots, file):
    scene = write_gantry_scene(tmp_path, file.format(folder=robots))
    assert _links(scene) == 1


@pytest.mark.parametrize("variable", ["AMENT_PREFIX_PATH", "ROS_PACKAGE_PATH"])
def test_a_model_may_be_in_a_package_of_ros(
    tmp_path, robots, monkeypatch, variable
):
    value = tmp_path / ("ws" if variable.startswith("AMENT") else "ws/share")
    monkeypatch.setenv(variable, str(value))
    file = "package://gantry_description/gantry.urdf"
    (tmp_path / "elsewhere").mkdir()
    assert _links(write_gantry_scene(tmp_path / "elsewhere", file)) == 1


def test_a_model_may_be_in_a_package_that_the_scene_names(tmp_path, robots):
    scene = write_gantry_scene(
        tmp_path,
        "package://robot/gantry.urdf",
        more="packages: {robot: ws/share/gantry_description}",
    )
    assert _links(scene) == 1


@pytest.mark.parametrize(
    "file, message",
    [
        ("gantry.urdf", r"gantry\.urdf' which does not exist; expected"),
        ("/nowhere/a.urdf", r"'/nowhere/a\.urdf' which does not exist"),
        ("package://my_arm/a.urdf", "unknown package 'my_arm'; name its fold"),
        ("ws", "ws is no file; expected a model"),
        ("pipe.urdf", r"pipe\.urdf is no regular file; expected one"),
    ],
)
def test_a_file_that_is_not_there_is_named(tmp_path, robots, file, message):
    os.mkfifo(tmp_path / "pipe.urdf")
    scene = write_gantry_scene(tmp_path, file)
    with pytest.raises(ValueError, match=message) as error:
        MakePredictionModel(LoadScene(scene))
    assert str(error.value).startswith(f"Scene {scene}: ")
    assert "add_model 'gantry': " in str(error.value) or "pipe" in file


def test_models_in_files_of_directives_are_made_readable(tmp_path, robots):
    (tmp_path / "robot.dmd.yaml").write_text(
        "directives:\n- add_model: {name: gantry, "
        "file: ws/share/gantry_description/gantry.urdf}\n"
    )
    scene = write_gantry_scene(tmp_path, "x")
    line = '- add_model: {name: gantry, file: "x"}'
    assert line in scene.read_text()
    scene.write_text(
        scene.read_text().replace(
            line, "- add_directives: {file: robot.dmd.yaml}"
        )
    )
    assert _links(scene) == 1


def test_the_scene_itself_is_left_as_it_is(tmp_path, robots):
    scene = LoadScene(
        write_gantry_scene(tmp_path, "ws/share/gantry_description/gantry.urdf")
    )
    before = str(scene.directives)
    MakePredictionModel(scene)
    assert str(scene.directives) == before


def test_errors_name_the_users_file_not_the_copy(tmp_path, robots):
    path = robots / "gantry.urdf"
    path.write_text(path.read_text().replace('type="prismatic"', 'type="odd"'))
    with pytest.raises(ValueError, match=r"odd") as error:
        _links(write_gantry_scene(tmp_path, str(path)))
    assert str(path) in str(error.value)
    assert "cache" not in str(error.value)


def test_a_visual_that_is_left_out_is_said_in_log_and_model(
    tmp_path, robots, caplog
):
    write_gantry(
        robots / "gantry.urdf", collision="wedge.stl", visual="missing.dae"
    )
    scene = LoadScene(write_gantry_scene(tmp_path, str(robots / "gantry.urdf")))
    models = [MakePredictionModel(scene) for _ in range(2)]
    (warning,) = models[0].warnings
    assert "missing.dae" in warning
    assert models[1].warnings == (warning,)
    # It is said once, however often the models are parsed.
    assert [r.getMessage() for r in caplog.records] == [warning]
