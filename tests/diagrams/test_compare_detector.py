"""The comparison of the simulated detector with real traces."""

import csv
from pathlib import Path

import numpy as np
from paths import DATA
from pydrake.math import RigidTransform, RollPitchYaw
import pytest
from recording_fixtures import make_planar_scene

from pbpf_drake.config.detector_config import DetectorConfig
from pbpf_drake.diagrams.compare_detector import (
    describe,
    describe_images,
    draw_errors,
    held_errors,
    is_stale,
    main,
    make_rows,
    read_trace,
)
from pbpf_drake.log.log_records import DetectionRecord, PoseRecord
from pbpf_drake.truth.truth_simulation import RecordRun

TRACES = DATA / "dope_error_traces"


def _record(poses: list[RigidTransform], times: np.ndarray) -> PoseRecord:
    return PoseRecord(
        times=times,
        q_WO=np.array([X.rotation().ToQuaternion().wxyz() for X in poses]),
        p_WO=np.array([X.translation() for X in poses]),
    )


def test_errors_are_those_of_the_last_detection_while_the_object_moves_on():
    scene = make_planar_scene()
    X_CW = scene.camera.pose().inverse()
    times = np.array([0.0, 10.0])
    truth = _record([RigidTransform(), RigidTransform([1.0, 0, 0])], times)
    turned = RigidTransform(RollPitchYaw(0, 0, 0.4), [0.0, 0.1, 0.0])
    detections = [
        DetectionRecord(name="block", time=t, received=t + 0.03, X_CO=X_CW @ X)
        for t, X in ((0.2, RigidTransform()), (5.0, turned))
    ]
    errors = held_errors(detections, truth, scene)
    updates = np.arange(0.16, 10.0, 0.16)[1:]  # From 0.23 s on.
    assert errors.shape == (len(updates), 2)
    later = updates >= 5.03
    np.testing.assert_allclose(errors[~later, 0], 0.1 * updates[~later])
    np.testing.assert_allclose(
        errors[later, 0], np.hypot(0.1 * updates[later], 0.1)
    )
    np.testing.assert_allclose(errors[:, 1], 0.4 * later, atol=1e-7)


def _series() -> np.ndarray:
    """Returns 40 clear updates, 4 outliers and good ones, 36 held ones."""
    rng = np.random.default_rng(0)
    clear = [0.05, 0.18] + 2e-3 * rng.standard_normal((40, 2))
    burst = [[0.3, 2.0], [0.05, 0.2], [0.06, 1.5], [0.4, 2.5]]
    held = [0.4, 2.5] + np.outer(np.arange(1, 37), [2e-3, 1e-3])
    return np.concatenate([clear, burst, held])


def test_only_what_drifts_after_the_first_jump_is_stale():
    np.testing.assert_array_equal(np.flatnonzero(is_stale(_series())),
                                  np.arange(44, 80))  # fmt: skip
    assert not is_stale(_series()[:40]).any()


def test_statistics_are_those_of_the_series():
    found = describe(_series())
    assert found["stale share"] == pytest.approx(36 / 80)
    assert found["position: outliers' median"] == pytest.approx(0.35)
    assert found["rotation: outliers' median"] == pytest.approx(2.0)
    assert found["position: share of outliers"] == pytest.approx(2 / 80)
    assert found["rotation: share of outliers"] == pytest.approx(3 / 80)
    assert found["position: last"] == pytest.approx(0.472)
    # The difference of two independent numbers.
    assert found["position: step noise"] == pytest.approx(2.8e-3, rel=0.3)


def test_what_can_not_be_counted_is_nan_and_then_empty():
    clear = _series()[:40]
    found = describe(clear)
    assert np.isnan(found["position: outliers' median"])
    rows = make_rows("cheezit_3", "cracker", [found, found], None)
    texts = {row[2]: row[3:] for row in rows}
    assert texts["position: outliers' median"] == [""] * 5
    assert texts["position: mean"][:2] == ["", "0.0520"]


def test_every_image_is_clear_or_partly_hidden_or_hidden():
    config = DetectorConfig(hidden_visibility=0.5, clear_visibility=0.9)
    visibility = np.array([1.0, 0.9, 0.89, 0.5, 0.49, 0.2, 0.1, 0.0])
    found = describe_images(visibility, config)
    assert found == {
        "images: clear": 2 / 8,
        "images: partly hidden": 2 / 8,
        "images: hidden": 4 / 8,
    }


def test_drawn_errors_are_a_function_of_the_seed_and_near_the_truth():
    scene = make_planar_scene(duration=0.5)
    recording = RecordRun(scene=scene)
    first, again, other = (
        draw_errors(recording, scene, seed)["block"] for seed in (0, 0, 1)
    )
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
    bias = scene.recording.detector.bias_position
    assert np.all(first[:, 0] > bias.min - 0.01)
    assert np.all(first[:, 0] < bias.max + 0.02)


def _write_trace(folder: Path) -> None:
    """A trace of Cheezit 1 that is 0.05 m and 0.2 rad off all the time."""
    for kind, error in ("pos", 0.05), ("ang", 0.2):
        lines = [f"{i},{0.16 * i:.2f},{error},DOPE\n" for i in range(1, 40)]
        name = f"cracker_scene1_early_DOPE_{kind}_01.csv"
        (folder / name).write_text("".join(lines))


@pytest.mark.parametrize(
    "options, said",
    [
        (["--runs", "0"], "--runs is 0; expected at least 1"),
        (["--draws", "-1"], "--draws is -1; expected at least 1"),
        (["--jobs", "0"], "--jobs is 0; expected at least 1"),
    ],
)
def test_what_cannot_be_done_is_said_before_anything_is_recorded(
    options, said, tmp_path, capsys
):
    _write_trace(tmp_path)
    assert main([str(tmp_path), *options]) == 1
    assert capsys.readouterr().err == f"compare_detector: {said}\n"


def test_a_folder_that_is_missing_or_without_traces_is_said(tmp_path, capsys):
    assert main([str(tmp_path / "nowhere")]) == 1
    assert "There is no folder" in capsys.readouterr().err
    assert main([str(tmp_path)]) == 1
    assert f"There is no trace in {tmp_path}" in capsys.readouterr().err


def test_the_command_puts_the_real_and_the_simulated_side_by_side(
    tmp_path, capsys
):
    _write_trace(tmp_path)
    out = tmp_path / "new" / "detector.csv"
    options = ["--scenes", "cheezit_1", "--runs", "1", "--draws", "3"]
    assert (
        main([str(tmp_path), *options, "--jobs", "1", "--out", str(out)]) == 0
    )
    with open(out, newline="", encoding="utf-8") as file:
        rows = {row["statistic"]: row for row in csv.DictReader(file)}
    mean = rows["position: mean"]
    assert (mean["scene"], mean["object"]) == ("cheezit_1", "cracker")
    assert (mean["real_trace"], mean["paper"]) == ("0.0500", "0.2890")
    low, high = (float(mean[f"simulated_{q}"]) for q in ("05", "95"))
    assert 0.05 < low < high < 1.0
    shares = [
        rows[f"images: {x}"] for x in ("clear", "partly hidden", "hidden")
    ]
    assert sum(float(s["simulated_50"]) for s in shares) == pytest.approx(
        1, abs=1e-3
    )
    # The box is pushed behind an obstacle.
    assert float(shares[0]["simulated_50"]) > 0.2
    assert float(shares[2]["simulated_50"]) > 0.4
    assert "outside" in capsys.readouterr().out


@pytest.mark.skipif(not TRACES.exists(), reason=f"{TRACES} is absent")
@pytest.mark.parametrize(
    "scene, position, rotation, stale",
    [("cheezit_1", 0.38, 1.86, 0.65), ("cheezit_2", 0.114, 1.06, 0.30),
     ("cheezit_3", 0.036, 0.171, 0.0), ("cheezit_4", 0.031, 0.217, 0.0)],
)  # fmt: skip
def test_real_traces_are_described_as_in_the_notes(
    scene, position, rotation, stale
):
    found = describe(read_trace(TRACES, scene))
    assert found["position: mean"] == pytest.approx(position, rel=0.05)
    assert found["rotation: mean"] == pytest.approx(rotation, rel=0.05)
    assert found["stale share"] == pytest.approx(stale, abs=0.05)
    assert read_trace(TRACES, "soup_1") is None
