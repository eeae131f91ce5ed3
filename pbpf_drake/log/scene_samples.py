"""Reads the samples that a scene asks for, and finds joints where they are."""

from dataclasses import dataclass
from pathlib import Path

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, ReadLimits
from pbpf_drake.bags.ros2_messages import is_one_of
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.joint_plan import JointPlan, unlogged_joints
from pbpf_drake.log.joint_topics import joint_topics
from pbpf_drake.log.log_sources import LogSources
from pbpf_drake.log.sample_extraction import JOINT_TYPES
from pbpf_drake.log.sample_reader import (
    LogSamples,
    ReadSamples,
    joint_names_of,
)


@dataclass(frozen=True)
class SceneSamples:
    """What a log has of what a scene asks for.

    Attributes:
        sources: where it is.
        samples: what is there.
        notes: count what is damaged, and say where joints were found.
    """

    sources: LogSources
    samples: LogSamples
    notes: LogNotes


def ReadSceneSamples(
    path: Path,
    scene: Scene,
    plan: JointPlan,
    limits: ReadLimits = DEFAULT_LIMITS,
) -> SceneSamples:
    """Reads the samples on a scene's topics.

    Joints that these topics lack are looked for on all others.

    Args:
        path: the file or folder.
        scene: names the topics.
        plan: names the joints.
        limits: what the file may hold at most.

    Raises:
        LogError: it is no log, a topic has messages of another type, or a joint
            is on several topics that the scene doesn't name.
    """
    sources = LogSources(scene)
    notes = LogNotes()
    samples = ReadSamples(path, sources.types, notes, limits)
    found = _MoreJointTopics(path, sources, samples, plan, limits)
    if scene.topics.tf_joints or not found:
        return SceneSamples(sources, samples, notes)
    # Everything is read again, so that everything is counted once.
    sources = LogSources(scene, found)
    notes = LogNotes()
    for topic, names in found.items():
        notes.Add(
            f"{topic}: took from it the joints {names}, which the topics that "
            "the scene names lack"
        )
    return SceneSamples(
        sources, ReadSamples(path, sources.types, notes, limits), notes
    )


def _MoreJointTopics(
    path: Path,
    sources: LogSources,
    samples: LogSamples,
    plan: JointPlan,
    limits: ReadLimits,
) -> dict[str, list[str]]:
    """Returns the topics with joints that the scene's topics lack."""
    there = joint_names_of(samples)
    missing = unlogged_joints(plan, there)
    others = [
        topic
        for topic, kind in samples.types.items()
        if topic not in sources.types and is_one_of(kind, JOINT_TYPES)
    ]
    # Without any joint states it is another log, or the topic's name is wrong.
    if not there or not missing or not others:
        return {}
    names = {t: _JointNames(path, t, limits) for t in others}
    return joint_topics(missing, names)


def _JointNames(path: Path, topic: str, limits: ReadLimits) -> set[str]:
    """Returns the joints on a topic that the scene doesn't name."""
    try:
        found = ReadSamples(path, {topic: JOINT_TYPES}, LogNotes(), limits)
    except LogError:  # It is no topic that could help.
        return set()
    return joint_names_of(found)
