"""The joints of a robot that can move, in the order of its positions."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JointIndex, ModelInstanceIndex


def RobotJointNames(
    plant: MultibodyPlant, robot: ModelInstanceIndex
) -> list[str]:
    """Returns the names of the joints that can move, in the order of q.

    Args:
        plant: finalized.
        robot: the robot's model instance.

    Raises:
        ValueError: a joint has more than one degree of freedom, the robot's
            base is free, or no joint can move.
    """
    joints = []
    for index in plant.GetJointIndices(robot):
        joint = plant.get_joint(JointIndex(index))
        if joint.num_positions() > 1:
            raise ValueError(
                f"joint {joint.name()!r} of the robot has "
                f"{joint.num_positions()} positions; expected 1: a fixed "
                "base (add_weld), and revolute or prismatic joints"
            )
        if joint.num_positions() == 1:
            joints.append(joint)
    if not joints:
        raise ValueError(
            "no joint of the robot can move; expected a revolute or prismatic "
            "joint, or another model as the robot"
        )
    joints.sort(key=lambda j: j.position_start())
    return [joint.name() for joint in joints]
