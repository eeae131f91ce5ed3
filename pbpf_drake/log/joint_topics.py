"""Finds the joints that a scene's topics lack on other topics of the log."""

from collections.abc import Collection, Mapping

from pbpf_drake.bags.log_error import LogError


def joint_topics(
    missing: Collection[str], names_by_topic: Mapping[str, Collection[str]]
) -> dict[str, list[str]]:
    """Returns the topics that have missing joints, with these joints.

    Args:
        missing: names in the log of joints that are to be found.
        names_by_topic: the joints on each topic that the scene doesn't name.

    Raises:
        LogError: more than one topic has a joint.
    """
    found: dict[str, list[str]] = {}
    for name in missing:
        having = [t for t, names in names_by_topic.items() if name in names]
        if len(having) > 1:
            raise LogError(
                f"the joint {name!r} is not on the scene's topics, but on "
                f"{' and '.join(sorted(having))}: name the right one in "
                "topics.more_joint_states"
            )
        for topic in having:
            found.setdefault(topic, []).append(name)
    return found
