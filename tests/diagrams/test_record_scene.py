import numpy as np
from pydrake.multibody.plant import MultibodyPlant
import pytest
from recording_fixtures import SCENES

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.record_scene import main
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.scene_models import AddSceneModels, data_folder
from pbpf_drake.truth.push_path import ActuatedJoints

SCENE = SCENES / "cheezit_1.yaml"
LOG = data_folder("diagrams") / "logs" / "cheezit_1.mcap"
RECORDING = """
recording:
  stiffness: [20000, 20000]
  damping: [400, 400]
  path:
    end_effector: pusher_probe
    waypoints:
    - {time: 0.0, translation: [0, 0, 0]}
    - {time: 0.2, translation: [0.01, 0, 0]}
"""


def _read(filename, scene):
    plant = MultibodyPlant(time_step=1e-3)
    robot = AddSceneModels(plant, scene).robot
    plant.Finalize()
    names = [plant.get_joint(j).name() for j in ActuatedJoints(plant, robot)]
    return ReadLog(filename=filename, scene=scene, joint_names=names)


@pytest.fixture(scope="module")
def shipped():
    return _read(LOG, LoadScene(SCENE))


def test_what_the_command_writes_can_be_read(tmp_path, capsys):
    text = (SCENES / "planar_push.yaml").read_text().split("\nrecording:")[0]
    scene = tmp_path / "scene.yaml"
    scene.write_text(text.replace("  block: {}", "  block: {class_id: steel}"))
    with scene.open("a") as file:
        file.write(RECORDING)
    out = tmp_path / "new_folder" / "log.mcap"
    options = ["--out", str(out), "--run", "3", "--duration", "0.2"]
    assert main(["--scene", str(scene), *options]) == 0
    printed = capsys.readouterr().out
    assert "Run 3, 0.2 s: 21 states of 2 joints, 4 images" in printed
    assert "block: moved by" in printed
    log = _read(out, LoadScene(scene))
    assert log.warnings == ()
    assert len(log.joints.times) == 21
    assert [d.name for d in log.detections] == ["block"] * 4


@pytest.mark.parametrize(
    "options, message",
    [
        (["--scene", "nowhere.yaml"], "no scene file"),
        (["--duration", "-1"], "recording.duration is -1.0"),
        (["--run", "-1"], "run is -1; expected 0 or more"),
    ],
)
def test_what_can_not_be_recorded_is_said_in_one_line(
    options, message, tmp_path, capsys
):
    assert main([*options, "--out", str(tmp_path / "log.mcap")]) == 1
    error = capsys.readouterr().err.splitlines()[-1]
    assert error.startswith("pbpf-record: ") and message in error
    assert not (tmp_path / "log.mcap").exists()


def test_shipped_log_is_whole_and_small(shipped):
    assert LOG.stat().st_size < 3e6
    assert shipped.warnings == ()
    assert shipped.duration == pytest.approx(25.0)
    assert len(shipped.joints.names) == 9
    np.testing.assert_allclose(np.diff(shipped.joints.times), 0.01, atol=1e-6)


def test_shipped_push_slides_and_turns_the_box_but_tips_it_not(shipped):
    truth = shipped.ground_truth["cracker"]
    way = truth.p_WO[-1] - truth.p_WO[0]
    assert way[1] > 0.3
    assert np.ptp(truth.p_WO[:, 2]) < 1e-3
    up = quaternions.rotate(truth.q_WO, np.array([1.0, 0.0, 0.0]))
    assert np.degrees(np.arccos(up[:, 2].clip(-1, 1))).max() < 1.0
    turn = quaternions.angle_between(truth.q_WO[0], truth.q_WO[-1])
    assert np.radians(10) < turn < np.radians(45)


def test_shipped_box_rests_before_the_push(shipped):
    truth = shipped.ground_truth["cracker"]
    before = truth.p_WO[truth.times < 2.0]
    assert np.linalg.norm(before - before[0], axis=1).max() < 1e-4


def test_shipped_box_is_lost_while_it_is_pushed_on(shipped):
    truth = shipped.ground_truth["cracker"]
    last = shipped.detections[-1].time
    hidden = truth.p_WO[truth.times > last]
    assert 0.45 < 1 - last / shipped.duration < 0.6
    assert np.linalg.norm(hidden[-1] - hidden[0]) > 0.15
    seen = np.diff([d.time for d in shipped.detections if d.time < 11.0])
    np.testing.assert_allclose(seen, 0.066, atol=1e-6)
