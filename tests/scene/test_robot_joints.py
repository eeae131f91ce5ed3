from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
import pytest

from pbpf_drake.scene.robot_joints import RobotJointNames


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


def test_a_robot_that_can_not_move_is_refused():
    plant, robot = _plant(f"<robot name='r'>{_link('a')}</robot>")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("a"))
    plant.Finalize()
    with pytest.raises(ValueError, match="no joint of the robot can move; exp"):
        RobotJointNames(plant, robot)
