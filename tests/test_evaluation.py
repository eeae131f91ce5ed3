"""One evaluation of a short log, and the keys of what it depends on."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pbpf_drake.diagrams import evaluation_keys
from pbpf_drake.diagrams.evaluation import (
    METRICS,
    Evaluation,
    SceneRun,
    evaluate,
    evaluation_code,
    evaluation_config,
    read_result,
    record,
    scene_name,
    scene_path,
)
from pbpf_drake.diagrams.evaluation_keys import evaluation_key, recording_key
from pbpf_drake.log_reader import ReadLog
from pbpf_drake.pose_errors import compute_errors
from pbpf_drake.prediction_model import MakePredictionModel
from pbpf_drake.scene import LoadScene
from pbpf_drake.scene_models import data_folder
from pbpf_drake.tracking import Track

FOLDER = data_folder("diagrams") / "scenes"
RUN = SceneRun("cheezit_1", 3, 0.7)
PBPF = Evaluation(RUN, "pbpf", 1, 4)


@pytest.fixture(scope="module")
def log() -> bytes:
    return record(RUN, evaluation_code())


@pytest.fixture(scope="module")
def evaluated(log) -> bytes:
    return evaluate(PBPF, log, evaluation_code())


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
    code = evaluation_code()
    assert record(RUN, code) == log
    assert record(replace(RUN, run=4), code) != log
    assert evaluate(PBPF, log, code) == evaluated
    assert evaluate(replace(PBPF, repeat=2), log, code) != evaluated


def test_a_worker_with_other_code_refuses(log):
    with pytest.raises(ValueError, match="worker has other code"):
        record(RUN, "other")
    with pytest.raises(ValueError, match="worker has other code"):
        evaluate(PBPF, log, "other")


def test_scenes_have_names_or_are_files(tmp_path):
    assert scene_path("cheezit_1") == FOLDER / "cheezit_1.yaml"
    own = str(tmp_path / "own.yaml")
    assert scene_path(own) == Path(own)
    assert scene_name(own) == "own" and scene_name("soup_1") == "soup_1"


def test_the_key_of_a_result_changes_with_all_that_it_depends_on(monkeypatch):
    key = evaluation_key(PBPF, b"log")
    keys = [
        key,
        evaluation_key(PBPF, b"other log"),
        evaluation_key(replace(PBPF, method="pbpf-v"), b"log"),
        evaluation_key(replace(PBPF, repeat=2), b"log"),
        evaluation_key(replace(PBPF, particles=5), b"log"),
        evaluation_key(replace(PBPF, scene_run=replace(RUN, run=4)), b"log"),
    ]
    monkeypatch.setattr(evaluation_keys, "evaluation_code", lambda: "other")
    keys.append(evaluation_key(PBPF, b"log"))
    assert all(keys.count(k) == 1 for k in keys)
    assert "parallelism" not in key["config"]


def _own_scene(folder: Path, **changes: str) -> str:
    """Writes a copy of a scene, with the text of it changed."""
    folder.mkdir(exist_ok=True)
    text = (FOLDER / "cheezit_1.yaml").read_text()
    for old, new in changes.items():
        assert text.count(old) == 1
        text = text.replace(old, new)
    (folder / "own.yaml").write_text(text)
    return str(folder / "own.yaml")


def test_keys_change_with_the_scene_but_not_with_its_comments(tmp_path):
    def keys(name: str, **changes: str):
        evaluation_keys._scene_digest.cache_clear()
        run = SceneRun(_own_scene(tmp_path / name, **changes), 0)
        evaluation = Evaluation(run, "pbpf", 0)
        return recording_key(run), evaluation_key(evaluation, b"log")

    recorded, evaluated = keys("same")
    # The log holds what recording says.
    new = keys("recording", **{"stddev: 0.006": "stddev: 0.007"})
    assert new[0] != recorded and new[1] == evaluated
    new = keys("camera", **{"fx: 605.904": "fx: 600.0"})
    assert new[0] != recorded and new[1] != evaluated
    new = keys(
        "filter", **{"robot: panda\n": "robot: panda\nfilter: {seed: 9}\n"}
    )
    assert new[0] == recorded
    new = keys("comment", **{"robot: panda\n": "# Hello.\nrobot: panda\n"})
    assert new == (recorded, evaluated)


def test_keys_change_with_the_files_of_the_models(tmp_path):
    sdf = (data_folder("models") / "cracker" / "cracker.sdf").read_text()
    found = []
    for mass in "0.411", "0.5":
        (tmp_path / "cracker.sdf").write_text(sdf.replace("0.411", mass))
        path = _own_scene(
            tmp_path,
            **{
                "package://pbpf_drake/cracker/cracker.sdf": (
                    "package://scene/cracker.sdf"
                )
            },
        )
        evaluation_keys._scene_digest.cache_clear()
        found.append(recording_key(SceneRun(path, 0))["scene"])
    assert found[0] != found[1]


def test_the_seed_of_a_filter_is_a_function_of_run_and_repeat():
    scene = LoadScene(FOLDER / "cheezit_1.yaml")
    assert evaluation_config(PBPF, scene).seed == 3001
