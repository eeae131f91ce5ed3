"""The diagram with the filter in the loop of a controller."""

from closed_loop_fixtures import closed_loop_scene
import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from pbpf_drake.diagrams.closed_loop.closed_loop_diagram import (
    FEEDBACKS,
    MakeClosedLoop,
)
from pbpf_drake.diagrams.closed_loop.push_task import draw_task


@pytest.fixture(scope="module")
def scene():
    return closed_loop_scene()


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
