"""A run in the layout of the authors' recordings is the same run."""

from dataclasses import replace

from authors_fixtures import TRUTH_IDS, authors_entries
from bag_fixtures import write_mcap, write_ros1
from filter_fixtures import SCENES
import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.log_reader import ReadLog
from pbpf_drake.prediction_model import MakePredictionModel
from pbpf_drake.quaternions import angle_between
from pbpf_drake.scene import LoadScene
from pbpf_drake.scene_models import data_folder
from pbpf_drake.tracking import DefaultConfig, Track

_DURATION = 4.0
LOG = data_folder("diagrams") / "logs" / "cheezit_1.mcap"


@pytest.fixture(scope="module")
def scene():
    return LoadScene(SCENES / "cheezit_1.yaml")


@pytest.fixture(scope="module")
def names(scene):
    return MakePredictionModel(scene).joint_names


@pytest.fixture(scope="module")
def ours(scene, names):
    """The beginning of the log that comes with the package."""
    log = ReadLog(filename=LOG, scene=scene, joint_names=names)
    early = log.joints.times < _DURATION
    joints = replace(
        log.joints,
        times=log.joints.times[early],
        positions=log.joints.positions[early],
        velocities=log.joints.velocities[early],
    )
    truth = log.ground_truth["cracker"]
    kept = truth.times < _DURATION
    truth = replace(
        truth,
        times=truth.times[kept],
        q_WO=truth.q_WO[kept],
        p_WO=truth.p_WO[kept],
    )
    detections = tuple(d for d in log.detections if d.received < _DURATION)
    return replace(
        log,
        joints=joints,
        detections=detections,
        ground_truth={"cracker": truth},
    )


@pytest.fixture(scope="module")
def authors_scene(tmp_path_factory):
    """The scene, for the authors' recordings."""
    text = (SCENES / "cheezit_1.yaml").read_text()
    assert "\ntopics:" not in text and text.count("  cracker: {}\n") == 1
    tracked = f"  cracker: {{ground_truth_id: {TRUTH_IDS['cracker']}}}\n"
    text = text.replace("  cracker: {}\n", tracked)
    path = tmp_path_factory.mktemp("scene") / "scene.yaml"
    path.write_text(text + "\ntopics: {preset: authors}\n")
    scene = LoadScene(path)
    # The camera is in the log, whatever the scene says.
    scene.camera.X_WC = Transform(RigidTransform([1.0, 2.0, 3.0]))
    return scene


@pytest.fixture(scope="module", params=["bag", "mcap"])
def theirs(request, ours, scene, authors_scene, names, tmp_path_factory):
    entries = authors_entries(ours, scene.camera.pose())
    path = tmp_path_factory.mktemp("log") / "log"
    write = {"bag": write_ros1, "mcap": write_mcap}[request.param]
    write(path, entries)
    return ReadLog(filename=path, scene=authors_scene, joint_names=names)


def test_joints_are_the_same(ours, theirs):
    assert theirs.start_time == ours.start_time
    np.testing.assert_allclose(
        theirs.joints.times, ours.joints.times, atol=1e-9
    )
    np.testing.assert_array_equal(
        theirs.joints.positions, ours.joints.positions
    )


def test_detections_and_the_camera_are_the_same(ours, theirs, scene):
    assert len(ours.detections) > 50
    assert len(theirs.detections) == len(ours.detections)
    assert theirs.X_WC.IsNearlyEqualTo(scene.camera.pose(), 1e-9)
    for a, b in zip(theirs.detections, ours.detections, strict=True):
        assert a.name == b.name
        np.testing.assert_allclose(
            [a.time, a.received], [b.time, b.received], atol=1e-9
        )
        assert a.X_CO.IsNearlyEqualTo(b.X_CO, 1e-9)


def test_ground_truth_is_the_same(ours, theirs):
    a, b = theirs.ground_truth["cracker"], ours.ground_truth["cracker"]
    np.testing.assert_allclose(a.times, b.times, atol=1e-9)
    np.testing.assert_allclose(a.p_WO, b.p_WO, atol=1e-9)
    # The arc tangent of a small angle is not exact to the last digit.
    assert np.max(angle_between(a.q_WO, b.q_WO)) < 1e-7


def test_nothing_is_left_out(theirs):
    assert theirs.warnings == ()


def test_the_track_is_the_same(ours, theirs, scene, authors_scene):
    config = replace(
        DefaultConfig(scene, "pbpf"), num_particles=5, num_threads=2
    )
    poses = [
        Track(
            scene=of,
            log=replace(log, joints=_first_second(log.joints)),
            method="pbpf",
            config=config,
        ).poses
        for of, log in ((scene, ours), (authors_scene, theirs))
    ]
    np.testing.assert_allclose(poses[0], poses[1], atol=1e-6)


def _first_second(joints):
    early = joints.times < 1
    return replace(
        joints,
        times=joints.times[early],
        positions=joints.positions[early],
        velocities=None,
    )
