"""The servo that moves a fingertip."""

from closed_loop_fixtures import closed_loop_scene
import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource
import pytest

from pbpf_drake.diagrams.closed_loop.cartesian_servo import CartesianServo
from pbpf_drake.scene.prediction_model import MakePredictionModel


@pytest.fixture(scope="module")
def servo():
    model = MakePredictionModel(closed_loop_scene())
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
