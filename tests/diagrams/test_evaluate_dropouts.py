"""Real dropouts of a camera, between real detections."""

from model_world import load_scene
import numpy as np
from paths import DATA
from push_fixtures import num_columns, rows_of_methods
import pytest

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams import evaluate_dropouts
from pbpf_drake.diagrams.evaluate_dropouts import (
    choose_config,
    evaluate,
    main,
    summarize,
)
from pbpf_drake.diagrams.jobs.scene_run import scene_path
from pbpf_drake.diagrams.recorded_pushes.two_finger_log import JOINT_NAMES
from pbpf_drake.scene.prediction_model import MakePredictionModel

PUSHES = DATA / "twofinger_pushes"
RUN = PUSHES / "bigrect_ridge/bigrect_ridge_30_50_60__2017-05-23_21-35-34.csv"
recorded = pytest.mark.skipif(
    not RUN.is_file(), reason=f"there is no recording {RUN.name}"
)


@pytest.fixture(scope="module")
def scene():
    return LoadScene(scene_path("two_finger_push"))


def test_joints_of_the_model_are_those_of_the_recordings(scene):
    assert MakePredictionModel(scene).joint_names == JOINT_NAMES


def test_fingers_are_where_their_joints_say():
    world, _, block = load_scene("two_finger_push")
    robot = world.plant.GetModelInstanceByName("pusher")
    q = [0.03, -0.3, 0.05, np.pi / 2]
    world.plant.SetPositions(world.context, robot, q)
    fingers = world.plant.GetBodyByName("pusher_fingers")
    # They push along y: side by side along x, 18 mm apart, 2.5 mm round.
    for side in (-0.009, 0.009):
        for x in (-0.0025, 0.0025):
            surface = np.array([0.03 + side + x, -0.3, 0.05])
            assert world.distance(fingers, surface) == pytest.approx(0)
    assert world.distance(fingers, np.array([0.03, -0.3, 0.05])) > 0.006
    top = 2 * block.EvalPoseInWorld(world.context).translation()[2]
    # Lifted, they clear the block; lowered, they reach through the table.
    assert world.distance(fingers, np.array([0.039, -0.3, top])) > 0.005
    world.plant.SetPositions(world.context, robot, [*q[:2], 0.0, q[3]])
    for z in (-0.02, top + 0.01):
        assert world.distance(fingers, np.array([0.039, -0.3, z])) < 0


def test_noise_is_the_papers_or_the_cameras(scene):
    paper = ParticleFilterConfig()
    for method in ("pbpf", "cvpf"):
        found = choose_config(scene, "paper", method, 3)
        assert found.process_noise == paper.process_noise
        assert found.detection_noise == paper.detection_noise
        found = choose_config(scene, "camera", method, 3)
        assert found.process_noise == scene.filter.process_noise
        assert found.detection_noise.position < 0.005
        assert found.seed == 3


@recorded
def test_a_block_that_is_pushed_on_unseen_is_expected_where_it_reappears():
    rows = {
        method: evaluate((RUN, 0, "camera", 0, method))
        for method in ("pbpf", "dope")
    }
    # For a second the camera loses it; it is pushed on by 29 mm.
    for row in rows.values():
        assert row["kind"] == "long"
        assert row["length_s"] == pytest.approx(1.1, abs=0.05)
        assert row["moved_m"] == pytest.approx(0.029, abs=0.001)
    assert rows["pbpf"]["error_m"] < 0.3 * rows["dope"]["error_m"]


@recorded
def test_holding_is_as_far_off_as_the_block_got():
    for index, kind in enumerate(["long", "pause", "pause"]):
        row = evaluate((RUN, index, "paper", 0, "dope"))
        assert row["kind"] == kind
        assert row["error_m"] == pytest.approx(row["moved_m"], abs=1e-6)
        assert row["error_rad"] == pytest.approx(row["moved_rad"], abs=1e-6)


def test_a_table_has_a_column_for_every_title():
    rows = rows_of_methods(
        run="a",
        dropout=0,
        seed=0,
        length_s=1.0,
        moved_m=0.02,
        moved_rad=0.1,
        error_m=0.004,
        error_rad=0.2,
    )
    line = summarize("pushed", "paper", rows)
    titles, _ = evaluate_dropouts._HEADER.split("\n")
    assert num_columns(line) == num_columns(titles)
    assert "| pushed | paper | 1 | 1.00 | 20.0 | 0.10 | 4.0 / 4.0 |" in line


def test_a_folder_without_recordings_is_refused(tmp_path, capsys):
    assert main([str(tmp_path)]) == 1
    assert "no CSV files" in capsys.readouterr().err
