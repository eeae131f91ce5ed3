import numpy as np
from physics_fixtures import (
    FLAT,
    HEIGHTS,
    PROBE_RADIUS,
    Simulation,
    make_model,
)
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
import pytest
from recording_fixtures import SCENES

from pbpf_drake.prediction_model import MakePredictionModel
from pbpf_drake.prescribed_robot import RobotJointNames
from pbpf_drake.scene import LoadScene

WALL = """
- add_model:
    name: wall
    file: package://pbpf_drake/obstacles/scene_4_support.sdf
- add_weld:
    parent: world
    child: wall::scene_4_support
    X_PC: {translation: [0.2035, 0.0, 0.08405]}
"""
# The wall's face is at x = 0.1.
AT_WALL = 0.1 - 0.045
TOUCHING = AT_WALL - 0.045 - PROBE_RADIUS


def _plant(urdf: str):
    plant = MultibodyPlant(time_step=0.0)
    (robot,) = Parser(plant).AddModelsFromString(urdf, "urdf")
    return plant, robot


def _link(name: str) -> str:
    return (
        f"<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' "
        "ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial></link>"
    )


def _joint(name: str, parent: str, child: str, kind: str) -> str:
    return (
        f"<joint name='{name}' type='{kind}'><parent link='{parent}'/>"
        f"<child link='{child}'/><axis xyz='0 0 1'/></joint>"
    )


@pytest.fixture(scope="module")
def panda():
    model = MakePredictionModel(LoadScene(SCENES / "cheezit_1.yaml"))
    return Simulation(model)


def test_joint_names_are_in_the_order_of_the_positions(panda):
    plant = panda.plant
    names = panda.model.joint_names
    assert names[:2] == ("panda_joint1", "panda_joint2")
    assert len(names) == len(panda.model.robot_q) == 9
    for name, row in zip(names, panda.model.robot_q, strict=True):
        assert plant.GetJointByName(name).position_start() == row


def test_a_robot_on_a_free_base_is_refused():
    plant, robot = _plant(f"<robot name='r'>{_link('a')}</robot>")
    plant.Finalize()
    with pytest.raises(ValueError, match="7 positions; expected 1: a fixed"):
        RobotJointNames(plant, robot)


def test_a_joint_with_several_positions_is_refused():
    urdf = (
        "<robot name='r' xmlns:drake='http://drake.mit.edu'>"
        f"{_link('a')}{_link('b')}<drake:joint name='socket' type='ball'>"
        "<parent link='a'/><child link='b'/></drake:joint></robot>"
    )
    plant, robot = _plant(urdf)
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("a"))
    plant.Finalize()
    with pytest.raises(ValueError, match="'socket' of the robot has 3 pos"):
        RobotJointNames(plant, robot)


def test_fixed_joints_are_not_listed():
    urdf = (
        f"<robot name='r'>{_link('a')}{_link('b')}{_link('c')}"
        f"{_joint('weld', 'a', 'b', 'fixed')}"
        f"{_joint('hinge', 'b', 'c', 'continuous')}</robot>"
    )
    plant, robot = _plant(urdf)
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("a"))
    plant.Finalize()
    assert RobotJointNames(plant, robot) == ["hinge"]


def test_an_arm_coasts_in_the_air_whatever_its_speed(panda):
    rng = np.random.default_rng(0)
    panda.set_pose(FLAT, [3.0, 0.0, 1.0])
    for _ in range(5):
        q, v = rng.uniform(-1, 1, (2, 9))
        panda.set_robot(q, v)
        panda.advance(0.16)
        np.testing.assert_allclose(panda.robot(), q + 0.16 * v, atol=1e-6)


def test_an_arm_passes_its_limits(panda):
    """Measured joints may be a little beyond a model's limits."""
    joint1 = panda.plant.GetJointByName("panda_joint1")
    assert np.isinf(joint1.position_upper_limits()[0])
    q, v = np.zeros(9), np.zeros(9)
    q[0], v[0] = 2.89, 0.5
    q[7], v[7] = 0.001, -0.1
    panda.set_robot(q, v)
    panda.advance(0.16)
    np.testing.assert_allclose(panda.robot(), q + 0.16 * v, atol=1e-5)


@pytest.mark.parametrize("mass", [0.1, 1.0, 5.0])
def test_a_probe_is_not_slowed_down_by_what_it_pushes(mass):
    simulation = Simulation(make_model("block"), friction=0.8, mass=mass)
    simulation.settle(FLAT, [AT_WALL, 0.0, HEIGHTS["block"]])
    start, speed = np.array([TOUCHING - 0.002, 0.01]), np.array([0.1, 0.02])
    simulation.set_robot(start, speed)
    simulation.advance(0.16)
    np.testing.assert_allclose(
        simulation.robot(), start + 0.16 * speed, atol=1e-5
    )
    assert simulation.pose()[4] > AT_WALL + 0.01


def test_a_probe_is_not_slowed_down_by_what_it_jams_against_a_wall():
    model = make_model("block", fixed=WALL)
    simulation = Simulation(model, friction=0.8, mass=1.0)
    simulation.settle(FLAT, [AT_WALL - 1e-4, 0.0, HEIGHTS["block"]])
    start, speed = np.array([TOUCHING - 1e-4, 0.0]), np.array([0.02, 0.0])
    simulation.set_robot(start, speed)
    simulation.advance(0.16)
    # 3 mm too little room: 90 N for each of the two corners at the wall.
    np.testing.assert_allclose(
        simulation.robot(), start + 0.16 * speed, atol=1e-5
    )
