"""Reads a log, whatever file it is in.

What messages say becomes samples, which are placed in time and brought from
the log's frames to the scene's. Then they become records: log_samples.py lists
these forms. What can be used is used: messages that are damaged, not finite,
twice there or out of order cost no more than themselves, and the log's
warnings count them. A log that the filter can't run on is refused with a
LogError.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, ReadLimits
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.input_usage import InputUsage, count_usage
from pbpf_drake.log.joint_merging import make_joint_record
from pbpf_drake.log.joint_plan import make_joint_plan
from pbpf_drake.log.log_frames import LogFrames
from pbpf_drake.log.log_records import (
    JointRecord,
    Log,
    PoseRecord,
)
from pbpf_drake.log.log_samples import PoseSample, RawStamped, Stamped
from pbpf_drake.log.log_timeline import LogTimeline, find_timeline
from pbpf_drake.log.pose_checks import is_usable_pose
from pbpf_drake.log.scene_detections import detections_of_scene
from pbpf_drake.log.scene_samples import ReadSceneSamples
from pbpf_drake.log.tf_joints import tf_joint_samples
from pbpf_drake.log.transform_tree import TransformTree, make_transform_tree
from pbpf_drake.log.truth_cleaning import make_pose_record
from pbpf_drake.model_facts import ModelFacts


def ReadLog(
    *,
    filename: str | Path,
    scene: Scene,
    joint_names: Sequence[str],
    facts: ModelFacts | None = None,
    limits: ReadLimits = DEFAULT_LIMITS,
) -> Log:
    """Reads what the filter needs of one recorded manipulation.

    ``scene.topics`` says where that is. A message's time is its header's
    stamp, or its log time where the stamp is zero. A detection is received at
    its log time, or at its stamp where the two are of different clocks.

    Args:
        filename: an MCAP file, a ROS 1 bag, or a ROS 2 bag or its folder.
        scene: names topics, frames, the joints in the log and the objects.
        joint_names: the robot's joints in the model's order, which becomes
            the order of the log's columns.
        facts: what is known of the scene's models, as a PredictionModel has
            it. Without it, joints that follow others must be in the log, and
            detections aren't compared with where things are.
        limits: what a file may hold at most.

    Returns:
        The log. Its ``warnings`` say what was left out. A log without
        detections is one of them. Its ``usage`` counts what was used.

    Raises:
        LogError: there is no such file, it isn't a log, a topic has messages
            of another type, no joint state can be used, or a joint is in no
            message, follows no other and isn't fixed by the scene.
    """
    path = Path(filename).expanduser()
    try:
        reader = _LogReader(
            path, scene, joint_names, facts or ModelFacts(), limits
        )
        return reader.Read()
    except LogError as error:
        raise LogError(f"Log {path}: {error}") from error


class _LogReader:
    """Everything that is known while one file is read."""

    def __init__(
        self,
        path: Path,
        scene: Scene,
        joint_names: Sequence[str],
        facts: ModelFacts,
        limits: ReadLimits,
    ):
        self._scene = scene
        self._joint_names = list(joint_names)
        self._facts = facts
        self._plan = make_joint_plan(scene.topics, joint_names, facts.mimics)
        self._input = ReadSceneSamples(path, scene, self._plan, limits)
        self._sources, self._notes = self._input.sources, self._input.notes
        self._samples = self._input.samples
        self._timeline = self._FindTimeline()
        self._usage: list[InputUsage] = []

    def Read(self) -> Log:
        tree = self._MakeTree()
        frames = self._MakeFrames(tree)
        record, start = self._Joints(tree)
        detections = detections_of_scene(
            self._input,
            scene=self._scene,
            timeline=self._timeline,
            frames=frames,
            facts=self._facts,
            start=start,
            usage=self._usage,
        )
        truth = self._GroundTruth(frames, start)
        self._CountUndecoded()
        return Log(
            joints=record,
            detections=detections,
            ground_truth=truth,
            start_time=start,
            warnings=self._notes.Sentences(),
            X_WC=frames.X_WC,
            usage=tuple(self._usage),
        )

    def _FindTimeline(self) -> LogTimeline:
        # The messages that say where the joints are: they have little delay.
        by_topic: Mapping[str, Sequence[RawStamped[object]]] = (
            self._samples.joints
        )
        if self._scene.topics.tf_joints:
            by_topic = self._samples.poses
        reference = max((by_topic[t] for t in self._sources.joints), key=len)
        if not reference:
            raise LogError(self._NoJointStates(self._samples.types))
        return find_timeline(reference, self._notes)

    def _NoJointStates(self, types: Mapping[str, str]) -> str:
        there = ", ".join(f"{t} ({types[t]})" for t in sorted(types))
        sources = self._sources
        expected = " or ".join(sources.types[sources.joints[0]])
        return (
            f"there are no joint states; expected {expected} on the topic "
            f"{' or '.join(sources.joints)}; the topics are: "
            f"{there or 'none'}"
            + "".join(f"; {s}" for s in self._notes.Sentences())
        )

    def _Joints(self, tree: TransformTree) -> tuple[JointRecord, int]:
        topics = self._scene.topics
        if topics.tf_joints:
            names = [
                name
                for name in self._plan.logged
                if name in topics.tf_joints or name not in self._plan.mimics
            ]
            placed = tf_joint_samples(tree, topics, names)
            parts = [(self._notes.On(topics.tf, "joint sample"), placed)]
            read = [len(placed)]
        else:
            parts = []
            for topic in self._sources.joints:
                notes = self._notes.On(topic, "message")
                placed = self._timeline.Place(
                    self._samples.joints[topic], notes
                )
                parts.append((notes, placed))
            read = [
                self._samples.counts[topic] for topic in self._sources.joints
            ]
        result = make_joint_record(
            parts,
            plan=self._plan,
            joint_names=self._joint_names,
            notes=self._notes,
        )
        for (notes, _), count in zip(parts, read, strict=True):
            count_usage(self._usage, notes, read=count)
        return result

    def _MakeTree(self) -> TransformTree:
        topics = self._scene.topics
        # What tf says once for all times may have been sent long before.
        static = self._samples.poses.get(topics.tf_static, [])
        notes = self._notes.On(topics.tf_static, "transform")
        return make_transform_tree(
            self._Transforms(topics.tf),
            [m.value for m in static if is_usable_pose(m.value, notes)],
            notes=self._notes,
        )

    def _MakeFrames(self, tree: TransformTree) -> LogFrames:
        topics = self._scene.topics
        return LogFrames(
            topics=topics,
            tree=tree,
            base=self._Transforms(topics.ground_truth_base),
            camera=self._scene.camera.pose(),
            notes=self._notes,
        )

    def _Transforms(self, topic: str) -> list[Stamped[PoseSample]]:
        """Returns the poses of a topic that a tree can be made of."""
        notes = self._notes.On(topic, "transform")
        placed = self._timeline.Place(self._samples.poses.get(topic, []), notes)
        return [m for m in placed if is_usable_pose(m.value, notes)]

    def _GroundTruth(
        self, frames: LogFrames, start: int
    ) -> dict[str, PoseRecord]:
        found = {}
        for name, source in self._sources.ground_truth.items():
            notes = self._notes.On(source, "message").Of(name)
            said = self._sources.Truth(self._samples.poses, name)
            placed = frames.InWorld(self._timeline.Place(said, notes), notes)
            record = make_pose_record(placed, start=start, notes=notes)
            if said:
                count_usage(self._usage, notes, read=len(said))
            if record:
                found[name] = record
        return found

    def _CountUndecoded(self) -> None:
        """Counts the messages that can't be decoded, so are of no object."""
        for topic in self._samples.poses:
            notes = self._notes.On(topic, "message")
            damaged = sum(notes.LeftOut().values())
            if damaged and topic not in self._sources.joints:
                count_usage(
                    self._usage, notes, read=self._samples.counts[topic]
                )
