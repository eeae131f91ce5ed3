"""What the command leaves where something goes wrong on the way."""

import json
import os
from pathlib import Path
import signal
import subprocess
import sys
import time

from command_fixtures import SCENE, run_command, write_push
from filter_fixtures import make_push_log
from mcap.reader import make_reader
import pytest
from socket_fixtures import listening

from pbpf_drake.diagrams import track_log
from pbpf_drake.tracking import track_outputs
from pbpf_drake.tracking.track_outputs import OUTPUTS

OPTIONS = ("--particles", "6", "--threads", "1", "--method", "pbpf")
KEPT = {"report.json", "errors.csv", "estimates.mcap"}


@pytest.fixture(scope="module")
def push(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    return write_push(folder / "push.mcap", make_push_log(duration=1.0))


def _report(out: Path) -> dict:
    return json.loads((out / "report.json").read_text("utf-8"))


def _names(out: Path) -> set[str]:
    return {path.name for path in out.iterdir()}


def _raise(*_args, **_kwargs):
    raise RuntimeError("out\nof ink")


@pytest.mark.parametrize(
    "function, name",
    [
        ("WriteErrors", "errors.csv"),
        ("PlotErrors", "errors.png"),
        ("PlotDiagnostics", "diagnostics.png"),
        ("WriteTrack", "estimates.mcap"),
        ("WriteReplay", "replay.html"),
    ],
)
def test_a_file_that_can_not_be_made_costs_only_itself(
    push, tmp_path, capsys, monkeypatch, function, name
):
    monkeypatch.setattr(track_outputs, function, _raise)
    (tmp_path / name).write_text("of an earlier run")
    assert run_command(push, tmp_path, *OPTIONS) == 3
    # The video is written together with the estimates.
    lost = {name} | ({"overlay.mp4"} if function == "WriteTrack" else set())
    assert _names(tmp_path) == set(OUTPUTS) - lost
    sentence = f"{name} couldn't be written: out of ink"
    assert f"Warning: {sentence}\n" in capsys.readouterr().out
    report = _report(tmp_path)
    assert sentence in report["warnings"]
    assert report["runs"][0]["steps"] == 6


def test_a_camera_of_one_pixel_costs_only_the_video(push, tmp_path, capsys):
    scene = tmp_path / "scene.yaml"
    text = SCENE.read_text().replace("width: 640", "width: 1")
    scene.write_text(text.replace("height: 480", "height: 1"))
    out = tmp_path / "out"
    assert run_command(push, out, *OPTIONS, scene=scene) == 3
    assert _names(out) == set(OUTPUTS) - {"overlay.mp4"}
    assert "1 x 1 pixels" in capsys.readouterr().out
    # That nothing can be seen by such a camera is another matter.
    warnings = _report(out)["warnings"]
    (failure,) = (w for w in warnings if "can't be written" in w)
    assert "overlay.mp4 can't be written" in failure


def test_the_report_is_there_before_anything_else_is_made(
    push, tmp_path, monkeypatch
):
    found = []

    def look(tracked, writing):
        found.append(_report(tmp_path)["runs"][0]["steps"])
        raise KeyboardInterrupt

    monkeypatch.setattr(track_outputs, "_write_rest", look)
    assert run_command(push, tmp_path, *OPTIONS) == 130
    assert found == [6]
    assert _names(tmp_path) == {"report.json"}


def _interrupt(monkeypatch, update: int) -> None:
    """Interrupts the command after so many updates of both methods."""
    updates = []

    class Bar:
        def __init__(self, **_options):
            pass

        def __enter__(self):
            return self

        def __exit__(self, *exception):
            pass

        def update(self):
            updates.append(1)
            if len(updates) == update:
                raise KeyboardInterrupt

    monkeypatch.setattr(track_log, "tqdm", Bar)


@pytest.mark.parametrize("update, steps", [(4, [4]), (9, [6, 3])])
def test_an_interruption_keeps_what_there_is(
    push, tmp_path, capsys, monkeypatch, update, steps
):
    _interrupt(monkeypatch, update)
    (tmp_path / "replay.html").write_text("of an earlier run")
    assert run_command(push, tmp_path, *OPTIONS) == 130
    assert _names(tmp_path) == KEPT
    report = _report(tmp_path)
    assert report["interrupted"] is True
    assert [run["steps"] for run in report["runs"]] == steps
    with (tmp_path / "estimates.mcap").open("rb") as file:
        channels = [c.topic for _, c, _ in make_reader(file).iter_messages()]
    assert channels.count("/pbpf/estimate/block") == steps[0]
    printed = capsys.readouterr()
    assert f"Interrupted after {steps[0]} of 6 updates" in printed.out
    assert printed.err == "pbpf-track: interrupted\n"


@pytest.fixture
def started(tmp_path):
    """Starts the command on the log that comes with it; kills it at the end."""
    processes = []

    def start(*options: str) -> subprocess.Popen:
        command = [sys.executable, "-m", "pbpf_drake.diagrams.track_log"]
        process = subprocess.Popen(
            [*command, "--out", "out", "--particles", "40", *options],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            # Whoever runs the tests may have asked for few lines of progress.
            env={**os.environ, "TQDM_MININTERVAL": "0.05"},
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
        processes.append(process)
        _until(process, "/156", 6)
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()


def _until(process: subprocess.Popen, text: str, times: int) -> None:
    """Reads the progress bar until it has shown a text so many times."""
    seen, end = "", time.monotonic() + 60
    while seen.count(text) < times and time.monotonic() < end:
        seen += process.stderr.read(1)


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
@pytest.mark.parametrize(
    "threads", ["1", pytest.param("2", marks=pytest.mark.slow)]
)
def test_ctrl_c_keeps_what_there_is_and_no_server_was_open(
    started, tmp_path, threads
):
    process = started("--threads", threads)
    assert listening(process.pid) == []
    os.killpg(process.pid, signal.SIGINT)
    printed, errors = process.communicate(timeout=60)
    assert process.returncode == 130
    assert "Traceback" not in errors
    assert "Interrupted after" in printed
    assert _names(tmp_path / "out") == KEPT
    assert 1 <= _report(tmp_path / "out")["runs"][0]["steps"] < 156


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_a_server_that_is_asked_for_is_for_this_machine_only(started):
    process = started("--show", "--threads", "1")
    (address,) = listening(process.pid)
    # 127.0.0.1, with the lowest byte first.
    assert address.startswith("0100007F:")
