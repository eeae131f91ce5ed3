"""The scene with three objects, and its log."""

from itertools import pairwise

from model_world import load_scene
import numpy as np

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder

FOLDER = data_folder("diagrams")
NAMES = ["cracker", "gelatin", "soup"]


def _scene():
    return LoadScene(FOLDER / "scenes" / "cheezit_gelatin_soup.yaml")


def _log() -> Log:
    scene = _scene()
    return ReadLog(
        filename=FOLDER / "logs" / "cheezit_gelatin_soup.mcap",
        scene=scene,
        joint_names=MakePredictionModel(scene).joint_names,
    )


def test_objects_stand_on_the_table_and_touch_nothing_else():
    world, _, _ = load_scene("cheezit_gelatin_soup")
    inspector = world.scene_graph.model_inspector()
    for name in NAMES:
        body = world.plant.GetBodyByName(name)
        assert abs(world.distance(body, _below(world, body))) < 1e-9
    pairs = world.query().ComputePointPairPenetration()
    touching = {
        inspector.GetName(g).split("::")[0]
        for pair in pairs
        if pair.depth > 1e-9
        for g in (pair.id_A, pair.id_B)
    }
    assert not touching & set(NAMES)


def _below(world, body) -> np.ndarray:
    """The point of the table's top below a body's origin."""
    point = body.EvalPoseInWorld(world.context).translation().copy()
    point[2] = 0.0
    return point


def test_each_object_is_pushed_into_the_next_by_the_one_before():
    """The hand moves the box first, the box moves both others."""
    log = _log()
    assert log.warnings == ()
    assert list(log.ground_truth) == NAMES == _scene().object_names()
    begins = []
    for truth in log.ground_truth.values():
        way = np.linalg.norm(truth.p_WO - truth.p_WO[0], axis=1)
        assert way[-1] > 0.2
        begins.append(truth.times[np.argmax(way > 1e-3)])
    assert all(a < b for a, b in pairwise(begins))


def test_objects_hide_each_other_later_on():
    log = _log()
    last = {d.name: d.time for d in log.detections}
    assert last["soup"] < 0.5 * log.duration
    assert last["gelatin"] < 0.9 * log.duration
    assert last["cracker"] > 0.98 * log.duration


def test_camera_and_robot_are_those_of_scene_1():
    scene = _scene()
    scene_1 = LoadScene(FOLDER / "scenes" / "cheezit_1.yaml")
    np.testing.assert_array_equal(
        scene.camera.pose().GetAsMatrix4(),
        scene_1.camera.pose().GetAsMatrix4(),
    )
    assert scene.robot == scene_1.robot
    starts = [
        next(
            d.add_model.default_joint_positions
            for d in s.directives
            if d.add_model and d.add_model.name == s.robot
        )
        for s in (scene, scene_1)
    ]
    assert starts[0].keys() == starts[1].keys()
    for joint in starts[0]:
        np.testing.assert_array_equal(starts[0][joint], starts[1][joint])
