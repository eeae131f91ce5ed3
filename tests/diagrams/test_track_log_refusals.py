"""What the command says where it can't do what it is asked for."""

from dataclasses import replace
import subprocess
import sys

from command_fixtures import SCENE, run_command, write_push
from filter_fixtures import SCENES, make_push_log, planar_scene
import pytest

from pbpf_drake.log.mcap_log_writer import WriteLog


@pytest.fixture(scope="module")
def push(tmp_path_factory):
    folder = tmp_path_factory.mktemp("logs")
    return write_push(folder / "push.mcap", make_push_log(duration=0.5))


def _refused(capsys, *arguments, **options) -> str:
    """Returns the one sentence that the command fails with."""
    assert run_command(*arguments, **options) == 1
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("pbpf-track: ")
    assert printed.err.count("\n") == 1
    return printed.err


def test_a_log_without_joint_states_is_refused(tmp_path, capsys):
    log = make_push_log(duration=0.5)
    path = tmp_path / "log.mcap"
    topics = replace(planar_scene().topics, joint_states="/other")
    WriteLog(filename=path, scene_topics=topics, log=log)
    message = _refused(capsys, path, tmp_path / "out")
    assert f"{path}: there are no joint states; expected" in message
    assert "/joint_states" in message and "/other" in message
    assert not (tmp_path / "out").exists()


def test_a_log_of_another_robot_is_refused(push, tmp_path, capsys):
    scene = SCENES / "cheezit_1.yaml"
    message = _refused(capsys, push, tmp_path / "out", scene=scene)
    assert "panda_joint1" in message and "pusher_x" in message


def test_a_log_that_is_too_short_is_refused(tmp_path, capsys):
    path = write_push(tmp_path / "short.mcap", make_push_log(duration=0.1))
    message = _refused(capsys, path, tmp_path / "out")
    assert f"{path} is 0.1 s long; expected at least one period" in message
    assert "0.16 s" in message


@pytest.mark.parametrize("content", [None, b"", b"no log at all"])
def test_what_is_no_log_is_refused(tmp_path, capsys, content):
    path = tmp_path / "log.mcap"
    if content is not None:
        path.write_bytes(content)
    assert str(path) in _refused(capsys, path, tmp_path / "out")


@pytest.mark.parametrize("content", [None, "", "robot: 3\n"])
def test_what_is_no_scene_is_refused(push, tmp_path, capsys, content):
    path = tmp_path / "scene.yaml"
    if content is not None:
        path.write_text(content)
    message = _refused(capsys, push, tmp_path / "out", scene=path)
    assert str(path) in message


def test_a_scene_whose_models_are_missing_is_refused(push, tmp_path, capsys):
    path = tmp_path / "scene.yaml"
    path.write_text(SCENE.read_text().replace("block.sdf", "brick.sdf"))
    message = _refused(capsys, push, tmp_path / "out", scene=path)
    assert str(path) in message and "brick.sdf" in message


@pytest.mark.parametrize(
    "option, value, field",
    [
        ("--particles", "0", "num_particles is 0"),
        ("--particles", "-1", "num_particles is -1"),
        ("--seed", "-1", "seed is -1"),
        ("--threads", "0", "parallelism is 0"),
    ],
)
def test_a_number_that_can_not_be_is_refused(
    push, tmp_path, capsys, option, value, field
):
    message = _refused(capsys, push, tmp_path / "out", option, value)
    assert field in message and "expected at least" in message


def test_a_folder_that_is_a_file_is_refused(push, tmp_path, capsys):
    out = tmp_path / "out"
    out.write_text("")
    assert str(out) in _refused(capsys, push, out)


@pytest.mark.parametrize(
    "option, value, choices",
    [("--method", "magic", "pbpf-v"), ("--particles", "many", "int")],
)
def test_an_argument_that_is_no_choice_is_refused_by_argparse(
    push, tmp_path, capsys, option, value, choices
):
    with pytest.raises(SystemExit) as error:
        run_command(push, tmp_path / "out", option, value)
    assert error.value.code == 2
    last = capsys.readouterr().err.splitlines()[-1]
    assert option in last and repr(value) in last and choices in last


def test_a_process_ends_with_the_exit_code_and_without_a_traceback(tmp_path):
    result = subprocess.run(
        [
            *(sys.executable, "-m", "pbpf_drake.diagrams.track_log"),
            *("--log", "none.mcap", "--scene", str(SCENE)),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert result.returncode == 1
    assert result.stdout == ""
    assert result.stderr.count("\n") == 1
    assert "pbpf-track: Log" in result.stderr and "none.mcap" in result.stderr
    assert list(tmp_path.iterdir()) == []
