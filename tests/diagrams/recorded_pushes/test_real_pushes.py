"""One recorded push through file, reader, filter and report.

The recordings are no part of this project. Where they are absent, as in a
clone of it, these tests are skipped.
"""

from dataclasses import replace

from filter_fixtures import SCENES
import numpy as np
from paths import DATA
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.recorded_pushes.planar_push_log import ReadPlanarPush
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.mcap_log_writer import WriteLog
from pbpf_drake.results.pose_errors import compute_errors
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.tracking.tracking_diagram import DefaultConfig, Track

PUSHES = DATA / "real_pushes"
# Undisturbed during the blackout.
PUSH = PUSHES / "StraightLine_2016_10_23_NoPerturbationsBlack.csv"

pytestmark = pytest.mark.skipif(
    not PUSH.is_file(), reason=f"there is no recording {PUSH.name}"
)


@pytest.fixture(scope="module")
def scene():
    return LoadScene(SCENES / "planar_push.yaml")


@pytest.fixture(scope="module")
def log(scene, tmp_path_factory):
    """The push as it comes out of a file."""
    model = MakePredictionModel(scene)
    push = ReadPlanarPush(
        PUSH,
        seed=0,
        X_WC=scene.camera.pose(),
        height=model.nominal_poses[0, 6],
    )
    path = tmp_path_factory.mktemp("real") / "push.mcap"
    WriteLog(filename=path, scene_topics=scene.topics, log=push)
    return ReadLog(filename=path, scene=scene, joint_names=model.joint_names)


@pytest.fixture(scope="module")
def errors(scene, log):
    """Position errors (in meters), by method."""
    return {
        method: compute_errors(
            Track(
                scene=scene,
                log=log,
                method=method,
                config=replace(DefaultConfig(scene, method), parallelism=2),
            ),
            "block",
            log.ground_truth["block"],
        ).position
        for method in ("pbpf", "cvpf", "dope")
    }


def _times(scene, errors) -> np.ndarray:
    """When the updates were (in seconds)."""
    return scene.filter.period * np.arange(1, len(errors["pbpf"]) + 1)


def test_the_log_is_whole(log):
    assert log.warnings == ()
    assert 8 < log.duration < 9
    assert list(log.ground_truth) == ["block"]
    seen = np.array([d.time for d in log.detections]) / log.duration
    assert not np.any((seen > 0.4) & (seen < 0.8))
    assert len(seen) == pytest.approx(0.6 * 15 * log.duration, abs=3)


def test_the_block_is_followed_through_the_blackout(scene, log, errors):
    last = np.flatnonzero(_times(scene, errors) < 0.8 * log.duration)[-1]
    end = {method: error[last] for method, error in errors.items()}
    # It was pushed on while nobody saw it.
    assert end["dope"] > 0.1
    assert end["pbpf"] < 0.5 * end["dope"]
    assert end["pbpf"] < end["cvpf"]


def test_a_second_after_detections_return_the_block_is_found(
    scene, log, errors
):
    times = _times(scene, errors)
    # The truth ends a little before the log.
    known = np.isfinite(errors["pbpf"])
    later = known & (times > 0.8 * log.duration + 1.0)
    assert np.count_nonzero(later) >= 3
    assert np.all(errors["pbpf"][later] < 0.03)


def test_before_the_blackout_the_filter_is_better_than_its_detections(
    scene, log, errors
):
    times = _times(scene, errors)
    before = (times > 1.0) & (times < 0.4 * log.duration)
    mean = {m: np.mean(error[before]) for m, error in errors.items()}
    assert mean["pbpf"] < 0.5 * mean["dope"]
