import csv
from dataclasses import replace
import json

from command_fixtures import SCENE, run_command, write_push
from filter_fixtures import PERIOD, make_push_log
from image_fixtures import TOPIC, flat_image, raw_image
from image_fixtures import write_log as write_image_log
from mcap.reader import make_reader
import numpy as np
import pytest

from pbpf_drake.bags.ros2_messages import IMAGE
from pbpf_drake.config.particle_filter_config import METHODS

OUTPUTS = {
    "report.json",
    "errors.csv",
    "errors.png",
    "diagnostics.png",
    "estimates.mcap",
    "overlay.mp4",
    "replay.html",
}
DURATION = 3.0
STEPS = 18


@pytest.fixture(scope="module")
def push(tmp_path_factory):
    """A log of a push with ground truth and a blackout."""
    folder = tmp_path_factory.mktemp("logs")
    return write_push(folder / "push.mcap", make_push_log(duration=DURATION))


def _run(log, out, *options, scene=SCENE) -> int:
    common = ["--particles", "6", "--threads", "1"]
    return run_command(log, out, *common, *options, scene=scene)


@pytest.fixture(scope="module", params=METHODS)
def tracked(request, push, tmp_path_factory):
    """What the command leaves behind, for every method."""
    out = tmp_path_factory.mktemp(request.param) / "new" / "folder"
    assert _run(push, out, "--method", request.param, "--seed", "3") == 0
    return request.param, out


def test_all_seven_files_are_written_and_nothing_else(tracked):
    _, out = tracked
    assert {path.name for path in out.iterdir()} == OUTPUTS
    assert (out / "errors.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    replay = (out / "replay.html").read_text("utf-8")
    assert replay.lstrip().lower().startswith("<!doctype html>")


def _strict(constant):
    raise ValueError(f"{constant} is not JSON")


def test_the_report_has_what_is_promised(tracked):
    method, out = tracked
    text = (out / "report.json").read_text("utf-8")
    report = json.loads(text, parse_constant=_strict)
    # DOPE alone is run beside every other method.
    runs = {run["method"]: run for run in report["runs"]}
    assert list(runs) == list(dict.fromkeys([method, "dope"]))
    assert report["warnings"] == []
    for name, run in runs.items():
        assert run["steps"] == STEPS
        assert run["particles"] == (0 if name == "dope" else 6)
        assert run["seed"] == 3
        times = run["update_time_ms"]
        assert 0 < times["median"] <= times["p95"] <= times["max"]
        block = run["objects"]["block"]
        assert block["compared_steps"] == STEPS
        assert 0.5 < block["detected_share"] < 1
        for errors in ("position_error_m", "rotation_error_rad"):
            assert set(block[errors]) == {"mean", "std", "median", "end"}
            assert all(np.isfinite(x) for x in block[errors].values())
        assert 0 < block["position_error_m"]["median"] < 0.1


def test_errors_are_listed_for_every_update_and_method(tracked):
    method, out = tracked
    with (out / "errors.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    methods = list(dict.fromkeys([method, "dope"]))
    assert [row["method"] for row in rows] == [
        m for m in methods for _ in range(STEPS)
    ]
    times = [float(row["time"]) for row in rows[:STEPS]]
    np.testing.assert_allclose(times, PERIOD * np.arange(1, STEPS + 1))
    report = json.loads((out / "report.json").read_text("utf-8"))
    mean = report["runs"][0]["objects"]["block"]["position_error_m"]["mean"]
    errors = [float(row["position_error_m"]) for row in rows[:STEPS]]
    assert np.mean(errors) == pytest.approx(mean, abs=1e-6)


def test_estimates_can_be_read_with_the_times_of_the_log(tracked):
    method, out = tracked
    with (out / "estimates.mcap").open("rb") as file:
        messages = list(make_reader(file).iter_messages())
    topics = [channel.topic for _, channel, _ in messages]
    assert topics.count("/pbpf/estimate/block") == STEPS
    particles = 0 if method == "dope" else STEPS
    assert topics.count("/pbpf/particles/block") == particles
    start = make_push_log(duration=DURATION).start_time
    assert 0 < min(m.log_time for _, _, m in messages) - start < 1e9


def test_a_table_and_a_progress_bar_are_printed(push, tmp_path, capsys):
    assert _run(push, tmp_path, "--method", "cvpf") == 0
    printed = capsys.readouterr()
    lines = printed.out.splitlines()
    assert [x for x in lines if x.startswith("block") and " cvpf " in x]
    assert [x for x in lines if x.startswith("block") and " dope " in x]
    assert f"Written to {tmp_path}" in printed.out
    assert f"{STEPS}/{STEPS}" in printed.err


def _numbers(out) -> dict:
    """The report without what depends on the time of the day."""
    report = json.loads((out / "report.json").read_text("utf-8"))
    for run in report["runs"]:
        run.pop("update_time_ms")
        run.pop("late_updates")
        run["config"].pop("parallelism", None)
    return report


def test_the_same_command_gives_the_same_numbers_with_more_threads(tmp_path):
    push = write_push(tmp_path / "push.mcap", make_push_log(duration=0.8))
    outs = [tmp_path / name for name in ("one", "two")]
    for out, threads in zip(outs, ("1", "2"), strict=True):
        options = ["--method", "pbpf", "--threads", threads]
        assert _run(push, out, *options) == 0
    assert _numbers(outs[0]) == _numbers(outs[1])
    first, second = ((out / "estimates.mcap").read_bytes() for out in outs)
    assert first == second


# Logs that lack something.


def test_a_log_without_detections_is_tracked_and_said(tmp_path, capsys):
    log = replace(make_push_log(duration=0.5), detections=())
    path = write_push(tmp_path / "blind.mcap", log)
    assert _run(path, tmp_path / "out") == 0
    warning = "there are no detections of ['block']"
    assert f"Warning: {warning}" in capsys.readouterr().out
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert warning in report["warnings"][0]
    for run in report["runs"]:
        block = run["objects"]["block"]
        assert block["detected_share"] == 0
        assert block["compared_steps"] == 0
        assert block["position_error_m"]["end"] is None


def test_a_log_without_ground_truth_is_tracked_without_errors(tmp_path):
    log = replace(make_push_log(duration=0.5), ground_truth={})
    path = write_push(tmp_path / "untrue.mcap", log)
    assert _run(path, tmp_path / "out", "--method", "dope") == 0
    names = {p.name for p in (tmp_path / "out").iterdir()}
    assert names == OUTPUTS
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    (run,) = report["runs"]
    assert run["objects"]["block"]["position_error_m"]["mean"] is None
    assert run["objects"]["block"]["detected_share"] > 0


@pytest.mark.parametrize(
    ("size", "expected"), [((640, 480), STEPS), ((320, 240), 0)]
)
def test_images_of_the_camera_are_drawn_on(tmp_path, size, expected):
    image = raw_image(flat_image(128, size))
    images = [(0.05 + 0.5 * i, TOPIC, IMAGE, image) for i in range(6)]
    log = make_push_log(duration=DURATION)
    path = write_image_log(tmp_path / "log.mcap", log, images)
    out = tmp_path / "out"
    assert _run(path, out, "--method", "dope") == 0
    with (out / "estimates.mcap").open("rb") as file:
        messages = make_reader(file).iter_messages()
        topics = [channel.topic for _, channel, _ in messages]
    assert topics.count("/pbpf/overlay/compressed") == expected
    report = json.loads((out / "report.json").read_text())
    if expected:
        assert report["warnings"] == []
    else:
        (warning,) = report["warnings"]
        assert f"{TOPIC}: left out 6 images of 320 x 240" in warning


def test_a_log_that_is_cut_off_is_used_as_far_as_it_goes(
    push, tmp_path, capsys
):
    path = tmp_path / "cut.mcap"
    data = push.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    assert _run(path, tmp_path / "out", "--method", "dope") == 0
    assert "Warning: the file is cut off" in capsys.readouterr().out
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert 1 <= report["runs"][0]["steps"] < STEPS
