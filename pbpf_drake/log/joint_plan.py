"""Where the motion of each of the robot's joints comes from."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.config.log_topics import LogTopics
from pbpf_drake.model_facts import MimicJoint


@dataclass(frozen=True)
class JointPlan:
    """Where the motion of each of the robot's joints comes from.

    Attributes:
        logged: names in the log by names in the model, of the joints that
            messages may have.
        fixed: positions of the joints that stay where they are (in radians or
            meters).
        mimics: the joints that follow another one, if no message has them.
    """

    logged: Mapping[str, str]
    fixed: Mapping[str, float]
    mimics: Mapping[str, MimicJoint]


def make_joint_plan(
    topics: LogTopics,
    joint_names: Sequence[str],
    mimics: Mapping[str, MimicJoint],
) -> JointPlan:
    """Returns where the motion of each joint comes from.

    Args:
        topics: renames joints, and fixes them.
        joint_names: the robot's joints.
        mimics: those that follow others, by their names.

    Raises:
        LogError: ``topics`` names a joint that the robot doesn't have.
    """
    for field in ("joint_names", "fixed_joints"):
        unknown = sorted(set(getattr(topics, field)) - set(joint_names))
        if unknown:
            raise LogError(
                f"the scene's topics.{field} names {unknown}, which the robot "
                f"does not have; its joints are {list(joint_names)}"
            )
    # Those that are coordinates of frames have the model's names.
    renamed = {} if topics.tf_joints else topics.joint_names
    return JointPlan(
        logged={
            name: renamed.get(name, name)
            for name in joint_names
            if name not in topics.fixed_joints
        },
        fixed=topics.fixed_joints,
        mimics=mimics,
    )


def unlogged_joints(plan: JointPlan, found: Collection[str]) -> list[str]:
    """Returns the names in the log of joints that are still to be found.

    Args:
        plan: where each joint's motion comes from.
        found: all joints that the log names.
    """
    return [
        in_log
        for name, in_log in plan.logged.items()
        if in_log not in found and name not in plan.mimics
    ]


def missing_joints(missing: Sequence[str], found: Sequence[str]) -> str:
    """Returns a clause on joints whose motion isn't known, with the remedies.

    Args:
        missing: their names in the log.
        found: all joints that the log names.
    """
    return (
        f"the log is without the joints {list(missing)}; it has "
        f"{found}: name a topic that has them in "
        "topics.more_joint_states, the names that they have in the log in "
        "topics.joint_names, or the positions of those that nobody measures "
        "in topics.fixed_joints"
    )
