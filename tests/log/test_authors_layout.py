"""A run in the layout of the authors' recordings is the same run."""

from dataclasses import replace
import json

from authors_fixtures import TRUTH_IDS, authors_entries
from bag_fixtures import write_mcap, write_ros1
from filter_fixtures import SCENES
import numpy as np
from pydrake.common.schema import Transform
from pydrake.common.yaml import yaml_load
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams import track_log
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.poses.quaternions import angle_between
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.tracking_diagram import DefaultConfig, Track

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
def authors_scene():
    """The scene file for the authors' recordings, but for its camera."""
    scene = LoadScene(SCENES / "authors_cheezit_1.yaml")
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


def test_what_there_is_is_the_same():
    """Drake's directives can't be shared with a file that has more in it."""
    ours, theirs = (
        yaml_load(filename=str(SCENES / name))
        for name in ("cheezit_1.yaml", "authors_cheezit_1.yaml")
    )
    for part in ("directives", "robot"):
        assert theirs[part] == ours[part]
    a = LoadScene(SCENES / "authors_cheezit_1.yaml")
    b = LoadScene(SCENES / "cheezit_1.yaml")
    assert a.tracked["cracker"].visibility == b.tracked["cracker"].visibility
    assert a.filter == b.filter
    assert a.ground_truth_ids() == {"cracker": TRUTH_IDS["cracker"]}
    assert a.camera.pose().IsExactlyEqualTo(b.camera.pose())
    for name in ("width", "height", "fx", "fy", "cx", "cy"):
        assert getattr(a.camera, name) == getattr(b.camera, name)


def test_their_bag_is_tracked_by_the_command(ours, scene, tmp_path, capsys):
    joints = _first_second(ours.joints)
    log = replace(
        ours,
        joints=joints,
        detections=tuple(d for d in ours.detections if d.received < 1),
    )
    bag = tmp_path / "their.bag"
    write_ros1(bag, authors_entries(log, scene.camera.pose()))
    out = tmp_path / "out"
    path = str(SCENES / "authors_cheezit_1.yaml")
    arguments = ["--scene", path, "--particles", "5", "--out", str(out)]
    assert track_log.main(["--log", str(bag), *arguments]) == 0
    report = json.loads((out / "report.json").read_text(encoding="utf-8"))
    assert report["warnings"] == []
    for run in report["runs"]:
        assert 0 < run["objects"]["cracker"]["position_error_m"]["mean"] < 0.2


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
        DefaultConfig(scene, "pbpf"), num_particles=5, parallelism=2
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
