from filter_fixtures import SCENES
import numpy as np
from pydrake.multibody.tree import BodyIndex
from pydrake.planning import RobotDiagramBuilder
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import (
    AddSceneModels,
    MakePackageMap,
    data_folder,
)

TEXT = (SCENES / "planar_push.yaml").read_text()
BOX = "<geometry><box><size>0.1 0.1 0.1</size></box></geometry>"
LINK = f'<link name="{{}}"><collision name="box">{BOX}</collision></link>'
SDF = '<sdf version="1.7"><model name="own">{}</model></sdf>'
ADD = """
- add_model: {name: own, file: package://scene/own.sdf}
robot: pusher"""


def _scene(tmp_path, *changes: tuple[str, str], body: str = ""):
    """Returns the planar pusher's scene with changes, beside own.sdf."""
    text = TEXT
    for old, new in changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (tmp_path / "my_scene.yaml").write_text(text)
    (tmp_path / "own.sdf").write_text(SDF.format(body))
    return LoadScene(tmp_path / "my_scene.yaml")


def _add(scene):
    builder = RobotDiagramBuilder(time_step=0.0)
    return builder.plant(), AddSceneModels(builder.plant(), scene)


def _names(plant, indices):
    return [
        plant.get_body(BodyIndex(i)).scoped_name().get_full() for i in indices
    ]


@pytest.mark.parametrize(
    "name, robot, objects, fixed",
    [
        ("planar_push", "pusher", ["block::block"], ["table::table"]),
        (
            "cheezit_1",
            "panda",
            ["cracker::cracker"],
            ["table::table", "obstacle::scene_1_obstacle"],
        ),
    ],
)
def test_models_of_the_shipped_scenes_have_their_roles(
    name, robot, objects, fixed
):
    plant, models = _add(LoadScene(SCENES / f"{name}.yaml"))
    assert plant.GetModelInstanceName(models.robot) == robot
    assert _names(plant, models.objects) == objects
    others = [n for n in _names(plant, models.fixed) if "World" not in n]
    assert others == fixed


def test_objects_are_in_the_order_of_the_scene_not_of_the_models(tmp_path):
    scene = _scene(
        tmp_path,
        ("\nrobot: pusher", ADD),
        ("  block: {}", "  own: {}\n  block: {}"),
        body=LINK.format("box"),
    )
    plant, models = _add(scene)
    assert _names(plant, models.objects) == ["own::box", "block::block"]


def test_files_are_found_beside_the_scene_and_in_the_package(tmp_path):
    packages = MakePackageMap(_scene(tmp_path))
    assert packages.GetPath("scene") == str(tmp_path)
    assert packages.GetPath("pbpf_drake") == str(data_folder("models"))


def test_files_are_found_in_the_packages_of_ros(tmp_path, monkeypatch):
    folder = tmp_path / "share" / "robots"
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(
        "<package><name>my_robots</name></package>"
    )
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "share"))
    packages = MakePackageMap(_scene(tmp_path))
    assert packages.GetPath("my_robots") == f"{folder}/"


def test_data_folders_exist_and_others_are_an_error():
    assert (data_folder("models") / "package.xml").is_file()
    assert (data_folder("diagrams") / "scenes").is_dir()
    with pytest.raises(FileNotFoundError, match="without its nothing"):
        data_folder("nothing")


TABLE_WELD = """- add_weld:
    parent: world
    child: table::table
    X_PC: {translation: [0.4, 0.0, 0.0]}
"""


@pytest.mark.parametrize(
    "changes, message",
    [
        ([("  block: {}", "  brick: {}")], r"tracked names 'brick'; .*'block'"),
        ([("robot: pusher", "robot: arm")], r"robot names 'arm'; .*'pusher'"),
        (
            [("  block: {}", "  table: {}")],
            r"tracked model 'table' is attached",
        ),
        (
            [(TABLE_WELD, "")],
            r"table::table can move, .*weld it .*track it",
        ),
        ([("block.sdf", "brick.sdf")], r"brick\.sdf' which does not exist"),
        (
            [("package://pbpf_drake/planar_push/b", "package://nowhere/b")],
            r"unknown package 'nowhere'",
        ),
        (
            [("child: table::table", "child: table::top")],
            r"no Frame named 'top'",
        ),
        (
            [("    name: block\n", "    name: table\n")],
            r"already contains a model instance named 'table'",
        ),
        (
            [("      pusher_x: [0.15]", "      pusher_z: [0.15]")],
            r"no Joint named 'pusher_z'",
        ),
    ],
)
def test_what_does_not_fit_is_named_with_the_scene(tmp_path, changes, message):
    scene = _scene(tmp_path, *changes)
    with pytest.raises(ValueError, match=r"my_scene\.yaml: .*" + message):
        _add(scene)


TWO_BODIES = (
    LINK.format("one")
    + LINK.format("two")
    + (
        '<joint name="fixed" type="fixed"><parent>one</parent>'
        "<child>two</child></joint>"
    )
)
MESH = LINK.format("box").replace(
    BOX, "<geometry><mesh><uri>missing.obj</uri></mesh></geometry>"
)
WELD = """
- add_weld: {parent: pusher::pusher_probe, child: own::box}
robot: pusher"""
HANG = """
- add_weld: {parent: own::box, child: own_too::box}
robot: pusher"""
TOO = "\n- add_model: {name: own_too, file: package://scene/own.sdf}"


@pytest.mark.parametrize(
    "end, body, message",
    [
        pytest.param(
            ADD,
            TWO_BODIES,
            r"tracked model 'own' has 2 bodies; expected one",
            id="two bodies",
        ),
        pytest.param(
            ADD,
            "<static>true</static>" + LINK.format("box"),
            r"tracked model 'own' is attached",
            id="static",
        ),
        pytest.param(ADD, MESH, r"missing\.obj", id="missing mesh"),
        pytest.param(ADD, "<link>", r"own\.sdf", id="not XML"),
        pytest.param(
            ADD.replace("\nrobot: pusher", WELD),
            LINK.format("box"),
            r"tracked model 'own' is attached .* no part of the robot",
            id="held by the robot",
        ),
        pytest.param(
            ADD.replace("\nrobot: pusher", TOO + HANG),
            LINK.format("box"),
            r"tracked model 'own' is attached",
            id="another hangs on it",
        ),
    ],
)
def test_a_model_that_can_not_be_tracked_is_named(tmp_path, end, body, message):
    scene = _scene(
        tmp_path,
        ("\nrobot: pusher", end),
        ("  block: {}", "  block: {}\n  own: {}"),
        body=body,
    )
    with pytest.raises(ValueError, match=r"my_scene\.yaml: (.|\n)*" + message):
        _add(scene)


def test_a_loose_model_that_nobody_tracks_is_named(tmp_path):
    scene = _scene(tmp_path, ("\nrobot: pusher", ADD), body=LINK.format("box"))
    with pytest.raises(ValueError, match=r"my_scene\.yaml: own::box can move"):
        _add(scene)


def test_a_robot_that_stands_on_nothing_is_named(tmp_path):
    weld = "- add_weld:\n    parent: world\n    child: pusher::pusher_base\n"
    scene = _scene(tmp_path, (weld, ""))
    with pytest.raises(ValueError, match=r"my_scene\.yaml: robot: .*fixed"):
        MakePredictionModel(scene)


def test_nominal_poses_are_the_scenes_own(tmp_path):
    turned = "{translation: [0.3, 0.1, 0.2], rotation: !Rpy {deg: [0, 0, 90]}}"
    scene = _scene(tmp_path, ("{translation: [0.2, 0.0, 0.0065]}", turned))
    model = MakePredictionModel(scene)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(
        model.nominal_poses, [[half, 0, 0, half, 0.3, 0.1, 0.2]], atol=1e-12
    )
    assert model.joint_names == ("pusher_x", "pusher_y")


def test_an_assertion_of_drakes_ends_in_a_sentence(tmp_path):
    """Drake would end the program."""
    change = ("name: probe_through_table", "name: ''")
    with pytest.raises(ValueError, match="my_scene.yaml: .*group_name.empty"):
        _add(_scene(tmp_path, change))
