import logging

from filter_fixtures import (
    BLOCKS_SCENE,
    FilterRun,
    detections,
    planar_scene,
    small_config,
    write_blocks_scene,
)
from mesh_fixtures import write_gantry, write_gantry_scene
import numpy as np
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_warnings import WarnOnce, robot_warnings

TABLE = """
- add_model: {name: table, file: package://pbpf_drake/table/table.sdf}
- add_weld: {parent: world, child: table::table}
"""


def _warnings(scene) -> tuple[str, ...]:
    return MakePredictionModel(scene).warnings


def test_shipped_scenes_have_none():
    assert _warnings(planar_scene()) == ()


@pytest.mark.parametrize(
    "position, carried",
    [
        ((0.2, 0.0, 0.0065), True),
        ((0.2, 0.0, 0.0), True),
        ((0.2, 0.0, 0.3), True),
        ((0.2, 0.0, 0.6), False),
        ((0.2, 0.0, -0.5), False),
        ((5.0, 0.0, 0.0065), False),
    ],
)
def test_an_object_is_carried_by_what_is_fixed_below_it(
    tmp_path, position, carried
):
    scene = write_blocks_scene(tmp_path, {"a": position})
    assert bool(_warnings(scene)) != carried


def test_an_object_is_carried_by_one_that_is_carried(tmp_path):
    stack = {"top": (0.2, 0, 0.7), "mid": (0.2, 0, 0.4), "low": (0.2, 0, 0.1)}
    assert not _warnings(write_blocks_scene(tmp_path, stack))
    stack["top"] = (0.7, 0, 0.7)
    (warning,) = _warnings(write_blocks_scene(tmp_path, stack))
    assert "nothing carries 'top' where the scene puts it" in warning


def test_a_wall_beside_an_object_does_not_carry_it(tmp_path):
    wall = tmp_path / "wall.sdf"
    wall.write_text(
        '<sdf version="1.7"><model name="wall"><link name="wall">'
        '<collision name="c"><geometry><box><size>0.1 1 2</size></box>'
        "</geometry></collision></link></model></sdf>"
    )
    add = "\n- add_model: {name: wall, file: wall.sdf}\n- add_weld: {parent: "
    add += "world, child: wall::wall, X_PC: {translation: [5.2, 0, 0]}}"
    scene = write_blocks_scene(tmp_path, {"a": (5.0, 0, 0)}, more=add)
    assert len(_warnings(scene)) == 1


def test_a_floor_without_an_end_carries_everything(tmp_path):
    (tmp_path / "floor.sdf").write_text(
        '<sdf version="1.7"><model name="floor"><link name="floor">'
        '<collision name="c"><geometry><plane><normal>0 0 1</normal></plane>'
        "</geometry></collision></link></model></sdf>"
    )
    add = "\n- add_model: {name: floor, file: floor.sdf}\n"
    add += "- add_weld: {parent: world, child: floor::floor}"
    scene = write_blocks_scene(tmp_path, {"a": (5.0, 0, 0)}, more=add)
    assert not _warnings(scene)


def test_a_scene_without_a_table_says_so_with_the_remedy(tmp_path, caplog):
    text = BLOCKS_SCENE.replace("[pusher::pusher_probe, table::table]",
                                "[pusher::pusher_probe]")  # fmt: skip
    text = text.replace(TABLE.replace("{", "{{").replace("}", "}}"), "\n")
    assert "table/table.sdf" not in text
    block = """
- add_model: {name: box, file: package://pbpf_drake/planar_push/block.sdf}"""
    path = tmp_path / "bare.yaml"
    path.write_text(text.format(blocks=block, names="box: {}"))
    (warning,) = _warnings(LoadScene(path))
    for part in (str(path), "'box'", "falls", "weld a table or a floor"):
        assert part in warning
    assert warning in caplog.messages


@pytest.fixture
def bare_gantry(tmp_path):
    """A scene whose robot can touch nothing."""
    write_gantry(tmp_path / "gantry.urdf", collision=None)
    return LoadScene(write_gantry_scene(tmp_path, "gantry.urdf"))


def test_a_robot_that_can_touch_nothing_is_said_with_its_links(bare_gantry):
    (warning,) = _warnings(bare_gantry)
    for part in ("robot 'gantry'", "(beam, tool)", "<collision>"):
        assert part in warning


@pytest.mark.parametrize("method", [True, False], ids=["pbpf-v", "pbpf"])
def test_with_a_robot_that_can_touch_nothing_objects_are_tracked(
    bare_gantry, method
):
    config = small_config(bare_gantry, num_particles=10, use_visibility=method)
    run = FilterRun(bare_gantry, config, joints=(0.0, 0.0))
    run.measure(detections(0.1, block=[0.105, 0.0, 0.0065]))
    for i in range(1, 4):
        run.update(i)
    run.move_joints(lambda t: np.array([0.5 * t, 0.0]), 5)
    assert run["tracked"] == [1]
    assert np.all(np.isfinite(run["particles"]))
    np.testing.assert_allclose(
        run["estimated_poses"][0, 4:], [0.105, 0.0, 0.0065], atol=0.02
    )


def test_a_robot_with_one_link_that_can_touch_needs_no_word():
    assert robot_warnings("arm", ["base", "tool"], 1) == []


def test_each_sentence_is_said_once(caplog):
    with caplog.at_level(logging.WARNING):
        WarnOnce(["only here, 100 %"])
        WarnOnce(["only here, 100 %", "and this"])
    assert caplog.messages == ["only here, 100 %", "and this"]
