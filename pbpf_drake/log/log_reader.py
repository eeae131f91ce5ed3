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
from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS, ReadLimits
from pbpf_drake.bags.ros2_messages import DETECTION_ARRAY, is_one_of
from pbpf_drake.config.log_topics import is_frame
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.detection_cleaning import make_detection_records
from pbpf_drake.log.joint_cleaning import make_joint_record
from pbpf_drake.log.log_clock import find_clock
from pbpf_drake.log.log_frames import LogFrames
from pbpf_drake.log.log_records import DetectionRecord, Log, PoseRecord
from pbpf_drake.log.log_samples import (
    JointSample,
    PoseSample,
    RawStamped,
    Stamped,
)
from pbpf_drake.log.log_sources import LogSources
from pbpf_drake.log.pose_checks import is_usable_pose
from pbpf_drake.log.sample_reader import LogSamples, ReadSamples
from pbpf_drake.log.tf_joints import tf_joint_samples
from pbpf_drake.log.transform_tree import TransformTree, make_transform_tree
from pbpf_drake.log.truth_cleaning import make_pose_record

_Joints = list[Stamped[JointSample]]
# By topic, what its messages say.
_Poses = Mapping[str, list[Stamped[PoseSample]]]


def ReadLog(
    *,
    filename: str | Path,
    scene: Scene,
    joint_names: Sequence[str],
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
        limits: what a file may hold at most.

    Returns:
        The log. Its ``warnings`` say what was left out. A log without
        detections is one of them.

    Raises:
        LogError: there is no such file, it isn't a log, a topic has messages
            of another type, or no joint state can be used.
    """
    path = Path(filename).expanduser()
    try:
        return _LogReader(scene, joint_names, limits).Read(path)
    except LogError as error:
        raise LogError(f"Log {path}: {error}") from error


class _LogReader:
    """Everything that is known while one file is read."""

    def __init__(
        self, scene: Scene, joint_names: Sequence[str], limits: ReadLimits
    ):
        self._scene = scene
        self._limits = limits
        self._joint_names = _joints_in_log(scene, joint_names)
        self._sources = LogSources(scene)
        self._notes = LogNotes()

    def Read(self, path: Path) -> Log:
        types = self._sources.types
        samples = ReadSamples(path, types, self._notes, self._limits)
        joints, poses = self._PlaceInTime(samples)
        # What tf says once for all times may have been sent long before.
        static = samples.poses.get(self._scene.topics.tf_static, [])
        tree = self._MakeTree(poses, static)
        frames = self._MakeFrames(poses, tree)
        if self._scene.topics.tf_joints:
            names = list(self._joint_names)
            joints = tf_joint_samples(tree, self._scene.topics, names)
        record, start = make_joint_record(
            joints,
            names=self._joint_names,
            notes=self._notes.On(self._sources.joints, "message"),
        )
        detections = self._Detections(poses, samples.types, frames, start)
        truth = self._GroundTruth(poses, frames, start)
        return Log(
            joints=record,
            detections=detections,
            ground_truth=truth,
            start_time=start,
            warnings=self._notes.Sentences(),
            X_WC=frames.X_WC,
        )

    def _PlaceInTime(self, samples: LogSamples) -> tuple[_Joints, _Poses]:
        source, topics = self._sources.joints, self._scene.topics
        # The messages that say where the joints are: they have little delay.
        reference: Sequence[RawStamped[object]] = samples.joints
        if topics.tf_joints:
            reference = samples.poses[source]
        if not reference:
            raise LogError(self._NoJointStates(samples.types))
        clock = find_clock(reference, self._notes)
        notes = self._notes.On(source, "message")
        joints = clock.Place(samples.joints, notes)
        poses = {
            topic: clock.Place(said, self._notes.On(topic, "message"))
            for topic, said in samples.poses.items()
            if topic != topics.tf_static
        }
        return joints, poses

    def _NoJointStates(self, types: Mapping[str, str]) -> str:
        there = ", ".join(f"{t} ({types[t]})" for t in sorted(types))
        topic = self._sources.joints
        expected = " or ".join(self._sources.types[topic])
        return (
            f"there are no joint states; expected {expected} on the topic "
            f"{topic}; the topics are: {there or 'none'}"
            + "".join(f"; {s}" for s in self._notes.Sentences())
        )

    def _MakeTree(
        self, poses: _Poses, static: Sequence[RawStamped[PoseSample]]
    ) -> TransformTree:
        topics = self._scene.topics
        notes = self._notes.On(topics.tf_static, "transform")
        return make_transform_tree(
            self._Transforms(poses, topics.tf),
            [m.value for m in static if is_usable_pose(m.value, notes)],
            notes=self._notes,
        )

    def _MakeFrames(self, poses: _Poses, tree: TransformTree) -> LogFrames:
        topics = self._scene.topics
        return LogFrames(
            topics=topics,
            tree=tree,
            base=self._Transforms(poses, topics.ground_truth_base),
            camera=self._scene.camera.pose(),
            notes=self._notes,
        )

    def _Transforms(
        self, poses: _Poses, topic: str
    ) -> list[Stamped[PoseSample]]:
        """Returns the poses of a topic that a tree can be made of."""
        notes = self._notes.On(topic, "transform")
        said = poses.get(topic, [])
        return [m for m in said if is_usable_pose(m.value, notes)]

    def _Detections(
        self,
        poses: _Poses,
        types: Mapping[str, str],
        frames: LogFrames,
        start: int,
    ) -> tuple[DetectionRecord, ...]:
        topics = self._scene.topics
        found: list[DetectionRecord] = []
        for source, name in self._sources.detections.items():
            # An array names its objects, also on a topic for one of them.
            names_them = is_one_of(types.get(source, ""), (DETECTION_ARRAY,))
            notes = self._notes.On(source, "detection")
            seen = self._sources.Poses(poses, source)
            found += make_detection_records(
                frames.InCamera(seen, notes),
                name=None if names_them else name,
                names_by_class=self._scene.object_by_class(),
                start=start,
                notes=notes,
            )
        if not found:
            kind = "in" if is_frame(topics.detections) else "on the topic"
            self._notes.Add(
                f"there are no detections of {self._scene.object_names()} "
                f"{kind} {topics.detections}: estimates stay at the scene's "
                "nominal poses"
            )
        return tuple(sorted(found, key=lambda d: (d.received, d.time, d.name)))

    def _GroundTruth(
        self, poses: _Poses, frames: LogFrames, start: int
    ) -> dict[str, PoseRecord]:
        found = {}
        for name, source in self._sources.ground_truth.items():
            notes = self._notes.On(source, "message")
            placed = frames.InWorld(self._sources.Truth(poses, name), notes)
            record = make_pose_record(placed, start=start, notes=notes)
            if record:
                found[name] = record
        return found


def _joints_in_log(scene: Scene, joint_names: Sequence[str]) -> dict[str, str]:
    """Returns the joints' names in the log by their names in the model."""
    renamed = scene.topics.joint_names
    unknown = sorted(set(renamed) - set(joint_names))
    if unknown:
        raise LogError(
            f"the scene's topics.joint_names names {unknown}, which the robot "
            f"does not have; its joints are {list(joint_names)}"
        )
    if scene.topics.tf_joints:
        return {name: name for name in joint_names}
    return {name: renamed.get(name, name) for name in joint_names}
