"""Which topics and frames of a log a scene asks for."""

from collections.abc import Collection, Mapping, Sequence

from pbpf_drake.config.log_topics import for_object, frame_name, is_frame
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.log_samples import PoseSample, RawStamped
from pbpf_drake.log.sample_extraction import (
    DETECTION_TYPES,
    JOINT_TYPES,
    TF_TYPES,
    TRUTH_TYPES,
)

# By topic, what its messages say.
_Poses = Mapping[str, Sequence[RawStamped[PoseSample]]]


class LogSources:
    """Where a scene's log holds what.

    A source is a topic, or "tf:" and a frame.

    Attributes:
        types: by topic, the types that its messages may have.
        joints: the topics that joint positions are from.
        detections: by source, the object that it is of; None where messages
            name their objects.
        ground_truth: by the object's name, its source.
    """

    def __init__(self, scene: Scene, more_joints: Collection[str] = ()):
        """Makes the lists.

        Args:
            scene: names topics, frames and objects.
            more_joints: topics of joint states that the scene doesn't name.
        """
        topics = scene.topics
        self._tf = topics.tf
        self._truth_ids = scene.ground_truth_ids()
        self._names_truth = "{name}" in topics.ground_truth
        class_ids = {v: k for k, v in scene.object_by_class().items()}
        self.joints = (
            (topics.tf,)
            if topics.tf_joints
            else (*topics.joint_topics(), *more_joints)
        )
        self.detections: dict[str, str | None] = {topics.detections: None}
        if "{name}" in topics.detections or len(class_ids) == 1:
            self.detections = {
                for_object(topics.detections, class_id): name
                for name, class_id in class_ids.items()
            }
        self.ground_truth = {
            name: for_object(topics.ground_truth, truth_id)
            for name, truth_id in self._truth_ids.items()
        }
        self.types = self._Types(scene)

    def _Types(self, scene: Scene) -> dict[str, tuple[str, ...]]:
        topics = scene.topics
        wanted: list[tuple[str, tuple[str, ...]]] = []
        if not topics.tf_joints:
            wanted += [(s, JOINT_TYPES) for s in self.joints]
        wanted += [(s, DETECTION_TYPES) for s in self.detections]
        wanted += [(s, TRUTH_TYPES) for s in self.ground_truth.values()]
        if topics.ground_truth_base:
            wanted.append((topics.ground_truth_base, TRUTH_TYPES))
        if topics.reference_frame:
            wanted += [(topics.tf, TF_TYPES), (topics.tf_static, TF_TYPES)]
        types: dict[str, tuple[str, ...]] = {}
        for source, accepted in wanted:
            if not is_frame(source):
                # The first use of a topic decides.
                types.setdefault(source, accepted)
        return types

    def Poses(self, poses: _Poses, source: str) -> list[RawStamped[PoseSample]]:
        """Returns what a source says.

        Args:
            poses: by topic.
            source: a topic, or "tf:" and a frame.
        """
        if not is_frame(source):
            return list(poses.get(source, ()))
        frame = frame_name(source)
        return [m for m in poses.get(self._tf, ()) if m.value.name == frame]

    def Truth(self, poses: _Poses, name: str) -> list[RawStamped[PoseSample]]:
        """Returns what the source of one object's true poses says of it.

        Args:
            poses: by topic.
            name: of the tracked model.
        """
        said = self.Poses(poses, self.ground_truth[name])
        if self._names_truth or len(self._truth_ids) == 1:
            return said
        wanted = frame_name(self._truth_ids[name])
        return [m for m in said if frame_name(m.value.name) == wanted]
