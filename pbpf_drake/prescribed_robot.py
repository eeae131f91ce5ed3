"""Makes a robot follow its measured motion, whatever it touches.

The robot's motion is measured, so nothing about it has to be simulated. With
huge rotor inertias, no gravity, no damping, no limits and no actuation its
joints coast: q(t) = q₀ + v t, and contact forces can't change that.
"""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    JointActuatorIndex,
    JointIndex,
    ModelInstanceIndex,
)

# In kg m² or kg. A contact force of 100 N for 0.16 s changes a joint's speed
# by 2e-4 rad/s or m/s at most.
_ROTOR_INERTIA = 1e5


def RobotJointNames(
    plant: MultibodyPlant, robot: ModelInstanceIndex
) -> list[str]:
    """Returns the names of the joints that move, in the order of q.

    The plant must be finalized.

    Raises:
        ValueError: a joint has more than one degree of freedom, or the
            robot's base is free.
    """
    joints = []
    for index in plant.GetJointIndices(robot):
        joint = plant.get_joint(JointIndex(index))
        if joint.num_positions() > 1:
            raise ValueError(
                f"joint {joint.name()!r} of the robot has "
                f"{joint.num_positions()} positions; expected 1: a fixed "
                "base, and revolute or prismatic joints"
            )
        if joint.num_positions() == 1:
            joints.append(joint)
    joints.sort(key=lambda j: j.position_start())
    return [joint.name() for joint in joints]


def FreeRobotJoints(plant: MultibodyPlant, robot: ModelInstanceIndex) -> None:
    """Removes what would disturb coasting; before the plant is finalized."""
    actuated = {
        plant.get_joint_actuator(JointActuatorIndex(i)).joint().index()
        for i in plant.GetJointActuatorIndices(robot)
    }
    for index in plant.GetJointIndices(robot):
        joint = plant.get_mutable_joint(JointIndex(index))
        if joint.num_velocities() != 1:
            continue
        joint.set_default_damping_vector([0.0])
        joint.set_position_limits([-float("inf")], [float("inf")])
        if joint.index() not in actuated:
            plant.AddJointActuator(f"{joint.name()}_prescribed", joint)
    plant.set_gravity_enabled(robot, False)


def MakeRobotCoast(plant: MultibodyPlant, robot: ModelInstanceIndex) -> None:
    """Sets the rotor inertias; after the plant is finalized."""
    for index in plant.GetJointActuatorIndices(robot):
        actuator = plant.get_mutable_joint_actuator(JointActuatorIndex(index))
        actuator.set_default_rotor_inertia(_ROTOR_INERTIA)
        actuator.set_default_gear_ratio(1.0)
