"""The recording and one evaluation of a short log, and their keys."""

from dataclasses import replace

import numpy as np
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.jobs.scene_digests import ReadSceneFiles
from pbpf_drake.diagrams.jobs.scene_recording import record, recording_key
from pbpf_drake.diagrams.jobs.scene_run import SceneRun
from pbpf_drake.diagrams.paper.evaluation import (
    METRICS,
    Evaluation,
    evaluate,
    evaluation_config,
    evaluation_key,
    read_result,
)
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.results.pose_errors import compute_errors
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.tracking_diagram import Track

FOLDER = data_folder("diagrams") / "scenes"
RUN = SceneRun("cheezit_1", 3, 0.7)
PBPF = Evaluation(RUN, "pbpf", 1, 4)
FILES = ReadSceneFiles("cheezit_1")


def _record(run: SceneRun) -> bytes:
    return record(run, recording_key(run, FILES))


def _evaluate(evaluation: Evaluation, log: bytes) -> bytes:
    return evaluate(evaluation, log, evaluation_key(evaluation, log, FILES))


@pytest.fixture(scope="module")
def log() -> bytes:
    return _record(RUN)


@pytest.fixture(scope="module")
def evaluated(log) -> bytes:
    return _evaluate(PBPF, log)


@pytest.fixture(scope="module")
def result(evaluated):
    return read_result(PBPF, evaluated)


def test_a_result_holds_the_errors_of_the_track(log, result, tmp_path):
    (tmp_path / "log.mcap").write_bytes(log)
    scene = LoadScene(FOLDER / "cheezit_1.yaml")
    names = MakePredictionModel(scene).joint_names
    read = ReadLog(
        filename=tmp_path / "log.mcap", scene=scene, joint_names=names
    )
    config = replace(scene.filter, num_particles=4, seed=3001)
    track = Track(scene=scene, log=read, method="pbpf", config=config)
    expected = compute_errors(track, "cracker", read.ground_truth["cracker"])
    errors = result.errors["cracker"]
    np.testing.assert_array_equal(result.times, track.times)
    np.testing.assert_array_equal(errors["position"], expected.position)
    np.testing.assert_array_equal(errors["rotation"], expected.rotation)
    assert len(result.times) == 4 and np.isfinite(errors["position"]).any()


def test_a_result_has_every_metric_and_they_fit_each_other(result):
    assert (result.scene, result.run, result.repeat) == ("cheezit_1", 3, 1)
    errors = result.errors["cracker"]
    assert set(errors) == set(METRICS)
    known = np.isfinite(errors["position"])
    for values in errors.values():
        np.testing.assert_array_equal(np.isfinite(values), known)
    assert np.all(errors["add_s"][known] <= errors["add"][known])
    assert np.all(errors["add"][known] <= errors["mssd"][known])
    # The box has no symmetry.
    np.testing.assert_allclose(
        errors["symmetric_rotation"][known], errors["rotation"][known]
    )


def test_runs_and_evaluations_are_pure_functions_of_what_they_are(
    log, evaluated
):
    assert _record(RUN) == log
    assert _record(replace(RUN, run=4)) != log
    assert _evaluate(PBPF, log) == evaluated
    assert _evaluate(replace(PBPF, repeat=2), log) != evaluated


@pytest.mark.parametrize(
    "name, expected", [("code", "the same code"), ("scene", "unchanged since")]
)
def test_who_finds_other_code_or_another_scene_refuses(name, expected, log):
    key = recording_key(RUN, FILES) | {name: "other"}
    with pytest.raises(ValueError, match=expected):
        record(RUN, key)
    key = evaluation_key(PBPF, log, FILES) | {name: "other"}
    with pytest.raises(ValueError, match=expected):
        evaluate(PBPF, log, key)


def test_the_key_of_a_log_changes_with_all_that_it_depends_on(monkeypatch):
    def key(run: SceneRun, **changes: str) -> dict:
        return recording_key(run, replace(FILES, **changes))

    keys = [
        key(RUN),
        key(replace(RUN, run=4)),
        key(replace(RUN, duration=0.8)),
        key(RUN, recorded_digest="other"),
    ]
    assert key(RUN, tracked_digest="other") == keys[0]
    name = "pbpf_drake.diagrams.jobs.scene_recording.code_digest"
    monkeypatch.setattr(name, lambda _: "other")
    keys.append(key(RUN))
    assert all(keys.count(k) == 1 for k in keys)


def test_the_key_of_a_result_changes_with_all_that_it_depends_on(monkeypatch):
    def key(evaluation: Evaluation, log: bytes = b"log", **changes: str):
        return evaluation_key(evaluation, log, replace(FILES, **changes))

    keys = [
        key(PBPF),
        key(PBPF, b"other log"),
        key(replace(PBPF, method="pbpf-v")),
        key(replace(PBPF, repeat=2)),
        key(replace(PBPF, particles=5)),
        key(replace(PBPF, scene_run=replace(RUN, run=4))),
        key(PBPF, tracked_digest="other"),
    ]
    assert key(PBPF, recorded_digest="other") == keys[0]
    assert "parallelism" not in keys[0]["config"]
    name = "pbpf_drake.diagrams.paper.evaluation.code_digest"
    monkeypatch.setattr(name, lambda _: "other")
    keys.append(key(PBPF))
    assert all(keys.count(k) == 1 for k in keys)


def test_the_seed_of_a_filter_is_a_function_of_run_and_repeat():
    scene = LoadScene(FOLDER / "cheezit_1.yaml")
    assert evaluation_config(PBPF, scene).seed == 3001
