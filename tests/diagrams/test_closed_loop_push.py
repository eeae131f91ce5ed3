"""The filter in the loop of a controller, and the parts of that diagram."""

import csv

from filter_fixtures import SCENES
import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams import closed_loop_push
from pbpf_drake.diagrams.closed_loop.cartesian_servo import CartesianServo
from pbpf_drake.diagrams.closed_loop_push import (
    FEEDBACKS,
    MakeClosedLoop,
    Outcome,
    draw_task,
    format_table,
    run_task,
)
from pbpf_drake.scene.prediction_model import MakePredictionModel


@pytest.fixture(scope="module")
def scene():
    scene = LoadScene(SCENES / "closed_loop_push.yaml")
    scene.filter.num_particles = 4
    return scene


@pytest.fixture(scope="module")
def servo(scene):
    model = MakePredictionModel(scene)
    plant, robot = model.diagram.plant(), model.models.robot
    hand = plant.GetFrameByName("panda_hand", robot)
    dut = CartesianServo(
        plant=plant,
        robot=robot,
        hand=hand,
        fingertip=np.array([0.0, 0.0, 0.1124]),
    )
    return dut, plant, hand


def test_the_joints_bring_the_fingertip_where_it_has_to_be(servo):
    dut, plant, hand = servo
    start = dut.FingertipAtStart()
    wanted = start + [0.03, 0.1, 0.01]
    builder = DiagramBuilder()
    builder.AddSystem(dut)
    source = builder.AddSystem(ConstantVectorSource(wanted))
    builder.Connect(source.get_output_port(), dut.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(1.0)
    context = dut.GetMyContextFromRoot(simulator.get_context())
    state = dut.get_output_port().Eval(context)
    work = plant.CreateDefaultContext()
    X_WH0 = hand.CalcPoseInWorld(work)
    q = plant.GetPositions(work)
    q[:9] = state[:9]
    plant.SetPositions(work, q)
    X_WH = hand.CalcPoseInWorld(work)
    np.testing.assert_allclose(X_WH @ [0, 0, 0.1124], wanted, atol=1e-4)
    np.testing.assert_allclose(
        X_WH.rotation().matrix(), X_WH0.rotation().matrix(), atol=1e-3
    )
    np.testing.assert_allclose(state[9:], 0, atol=1e-3)


def test_goals_are_hidden_and_starts_are_not_and_both_are_random(scene):
    tasks = [draw_task(scene, seed) for seed in range(30)]
    goals = np.array([task.goal for task in tasks])
    assert np.all(goals[:, 1] >= 0.2) and np.all(goals[:, 1] <= 0.36)
    assert len(np.unique(goals[:, 0])) == 30
    assert np.all(np.array([task.start for task in tasks])[:, 1] < -0.06)
    again = draw_task(scene, 3)
    np.testing.assert_array_equal(tasks[3].goal, again.goal)


@pytest.mark.parametrize("feedback", FEEDBACKS)
def test_the_loop_is_closed_by_what_was_asked_for(scene, feedback):
    """A diagram with an algebraic loop could not even be built."""
    loop = MakeClosedLoop(
        scene=scene, feedback=feedback, task=draw_task(scene, 0)
    )
    start = loop.object_position()
    simulator = Simulator(loop.diagram, loop.context)
    simulator.AdvanceTo(0.5)
    context = loop.controller.GetMyContextFromRoot(loop.context)
    (X_WO,) = loop.controller.GetInputPort("estimated_poses").Eval(context)
    error = np.linalg.norm((X_WO.translation() - start)[:2])
    # The truth is that of the last update, before the robot is there.
    assert error < (1e-3 if feedback == "truth" else 0.05)
    assert (error < 1e-3) == (feedback == "truth")
    camera = loop.camera.GetMyContextFromRoot(loop.context)
    assert loop.camera.GetOutputPort("visibility").Eval(camera) > 0.8


def test_detections_are_out_when_their_latency_has_passed(scene):
    loop = MakeClosedLoop(
        scene=scene, feedback="truth", task=draw_task(scene, 0)
    )
    detector = scene.recording.detector
    simulator = Simulator(loop.diagram, loop.context)
    context = loop.camera.GetMyContextFromRoot(loop.context)
    port = loop.camera.GetOutputPort("dope_measurement")
    stamps = []
    for time in (0.5, 0.9, 1.1, 1.6):
        simulator.AdvanceTo(
            detector.latency + (time - 0.5) * detector.period
            if time > 0.5
            else 0.5 * detector.latency
        )
        found = port.Eval(context).detections
        stamps.append(found["gelatin"].time if found else None)
    assert stamps[0] is None
    np.testing.assert_allclose(stamps[1:3], [0.0, 0.0], atol=1e-9)
    assert stamps[3] == pytest.approx(detector.period)


def test_a_run_is_repeatable_and_ends_in_time(scene):
    outcomes = [run_task(scene, "dope", 5, duration=0.5) for _ in range(2)]
    assert outcomes[0].distance == outcomes[1].distance
    np.testing.assert_array_equal(outcomes[0].goal, draw_task(scene, 5).goal)
    assert not outcomes[0].success
    assert outcomes[0].hidden == 0


def _outcome(feedback: str, x: float) -> Outcome:
    return Outcome(feedback, 0, np.zeros(2), np.array([x, 0.0]), 0.5)


def test_the_table_counts_what_is_within_40_mm():
    outcomes = [_outcome("dope", x) for x in (0.039, 0.041, 0.2)]
    lines = format_table([*outcomes, _outcome("truth", 0.01)]).splitlines()
    assert lines[2] == "| dope | 1 of 3 | 41 / 168 |"
    assert lines[3] == "| truth | 1 of 1 | 10 / 10 |"


def test_all_runs_are_written(tmp_path, monkeypatch):
    monkeypatch.setattr(
        closed_loop_push,
        "run_task",
        lambda scene, feedback, seed: _outcome(feedback, 0.01 * seed),
    )
    out = tmp_path / "out.csv"
    arguments = ["--goals", "2", "--feedback", "dope", "truth"]
    assert closed_loop_push.main([*arguments, "--out", str(out)]) == 0
    with out.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["feedback"] for row in rows] == ["dope", "truth"] * 2
    assert [row["distance"] for row in rows[2:]] == ["0.0100"] * 2
