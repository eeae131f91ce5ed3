"""Robots as they come in ROS push an object, and it is tracked."""

import json
from pathlib import Path

from mesh_fixtures import write_gantry, write_gantry_scene, write_mesh
from paths import DATA
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams import record_scene, track_log
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.scene.prediction_model import MakePredictionModel

ROBOTS = DATA / "robots" / "example-robot-data"
# The tool is beside a box that lies on a table, and pushes it by 14 cm or more.
SCENE = """
directives:
- add_model: {{name: table, file: package://pbpf_drake/table/table.sdf}}
- add_weld:
    parent: world
    child: table::table
    X_PC: {{translation: [0.5, 0.0, -0.001]}}
- add_model:
    name: arm
    file: package://example-robot-data/robots/{file}
    default_joint_positions: {{{joints}}}
{weld}
- add_model:
    name: cracker
    file: package://pbpf_drake/cracker/cracker.sdf
    default_free_body_pose:
      cracker: {{translation: [0.45, -0.04, 0.0305]}}
packages: {{example-robot-data: {folder}}}
robot: arm
tracked: {{cracker: {{}}}}
camera:
  X_WC:
    translation: [1.3, 0.1, 0.6]
    rotation: !Rpy {{deg: [-125.0, 0.0, 90.0]}}
recording:
  duration: 3.0
  time_step: 0.002
  stiffness: {stiffness}
  damping: {damping}
  path:
    end_effector: {tool}
    waypoints:
    - {{time: 0.2, translation: [0.0, 0.0, 0.0]}}
    - {{time: 2.8, translation: [0.0, 0.18, 0.0]}}
"""
ARMS = {
    "ur5": dict(
        file="ur_description/urdf/ur5_robot.urdf",
        joints="shoulder_pan_joint: [2.8484], shoulder_lift_joint: [-2.1061], "
        "elbow_joint: [-2.0961], wrist_1_joint: [-0.5108], "
        "wrist_2_joint: [1.5703], wrist_3_joint: [-1.8632]",
        weld="",  # The file has one.
        stiffness=[600, 600, 600, 250, 150, 50],
        damping=[50, 50, 50, 30, 25, 15],
        tool="tool0",
    ),
    "panda": dict(
        file="panda_description/urdf/panda.urdf",
        joints="panda_joint1: [-0.4273], panda_joint2: [0.5396], "
        "panda_joint3: [-0.064], panda_joint4: [-2.2974], "
        "panda_joint5: [0.1075], panda_joint6: [2.8338], "
        "panda_joint7: [0.2001], panda_finger_joint1: [0.02], "
        "panda_finger_joint2: [0.02]",
        weld="- add_weld: {parent: world, child: arm::panda_link0}",
        stiffness=[600, 600, 600, 600, 250, 150, 50, 400, 400],
        damping=[50, 50, 50, 50, 30, 25, 15, 20, 20],
        tool="panda_hand_tcp",
    ),
}


def _push_and_track(scene: Path, out: Path, name: str) -> tuple[float, float]:
    """Records and tracks a push.

    Returns:
        How far the object has moved, and how far off its estimate is at the end
        (in meters).
    """
    log = out / "a.mcap"
    arguments = ["--scene", str(scene)]
    assert record_scene.main([*arguments, "--out", str(log)]) == 0
    arguments += ["--log", str(log), "--out", str(out / "track")]
    options = ["--particles", "12", "--threads", "1"]
    assert track_log.main([*arguments, *options]) == 0
    loaded = LoadScene(scene)
    names = MakePredictionModel(loaded).joint_names
    truth = ReadLog(filename=log, scene=loaded, joint_names=names)
    p_WO = truth.ground_truth[name].p_WO
    report = json.loads((out / "track" / "report.json").read_text())
    error = report["runs"][0]["objects"][name]["position_error_m"]["end"]
    return float(abs(p_WO[-1] - p_WO[0]).max()), error


@pytest.mark.parametrize("collision, visual", [("stl", "dae"), ("dae", "stl")])
def test_a_robot_of_stl_or_dae_without_actuators_pushes(
    tmp_path, collision, visual
):
    package = tmp_path / "gantry_description"
    (package / "meshes").mkdir(parents=True)
    (package / "urdf").mkdir()
    url = "package://gantry_description/meshes/wedge."
    for ending in (collision, visual):
        write_mesh(package / "meshes" / f"wedge.{ending}")
    write_gantry(
        package / "urdf" / "gantry.urdf",
        collision=url + collision,
        visual=url + visual,
    )
    scene = write_gantry_scene(tmp_path, str(package / "urdf" / "gantry.urdf"))
    moved, error = _push_and_track(scene, tmp_path, "block")
    # The tool's wedge starts 60 mm in front of the block's side.
    assert moved == pytest.approx(0.1, abs=0.01)
    assert error < 0.06


@pytest.mark.slow
@pytest.mark.parametrize("arm", ARMS)
def test_real_arms_push(tmp_path, arm):
    if not ROBOTS.is_dir():
        pytest.skip(f"there are no robots in {ROBOTS}")
    scene = tmp_path / "scene.yaml"
    scene.write_text(SCENE.format(folder=ROBOTS, **ARMS[arm]))
    assert MakePredictionModel(LoadScene(scene)).warnings == ()
    moved, error = _push_and_track(scene, tmp_path, "cracker")
    assert moved > 0.1
    assert error < 0.09
