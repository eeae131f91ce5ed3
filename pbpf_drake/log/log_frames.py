"""Brings the poses of a log from its frames to those of the scene."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.bags.log_notes import LogNotes, TopicNotes
from pbpf_drake.config.log_topics import LogTopics, frame_name
from pbpf_drake.log.log_samples import PoseSample, Stamped
from pbpf_drake.log.pose_checks import is_usable_pose, unit
from pbpf_drake.log.transform_tree import (
    PoseArrays,
    TransformTree,
    compose,
    make_transform_tree,
)
from pbpf_drake.poses.pose_conversion import pose_array, rigid_transform
from pbpf_drake.poses.pose_statistics import mean_pose
from pbpf_drake.poses.quaternions import angle_between

# A camera that moves further than this is not at rest (in meters and radians).
_MAX_CAMERA_MOTION = (0.01, 0.02)
# The name of the motion capture's own frame, whatever the log calls it.
_CAPTURE = "motion capture"


class LogFrames:
    """Where the log's frames are in the scene.

    Attributes:
        X_WC: the camera's pose in the world; None where the log doesn't say
            it.
    """

    def __init__(
        self,
        *,
        topics: LogTopics,
        tree: TransformTree,
        base: Sequence[Stamped[PoseSample]],
        camera: RigidTransform,
        notes: LogNotes,
    ):
        """Finds the camera.

        Args:
            topics: names the frames.
            tree: what tf says.
            base: poses of the reference frame as the ground truth's own system
                sees it; empty where tf connects the two.
            camera: where the scene says that the camera is.
            notes: says what is not as it should be.
        """
        self._topics = topics
        self._tree = tree
        self._notes = notes
        self._camera_frame = frame_name(topics.camera_frame)
        self._reference = frame_name(topics.reference_frame)
        self._base = _base_tree(base, self._reference, notes)
        self.X_WC = self._FindCamera()
        self._camera = self.X_WC or camera

    def InCamera(
        self, messages: Sequence[Stamped[PoseSample]], notes: TopicNotes
    ) -> list[Stamped[PoseSample]]:
        """Returns detections whose poses are X_CO, whatever their frames.

        Args:
            messages: poses in the frames that they name.
            notes: counts what is left out.
        """
        if not self._reference:
            return list(messages)
        return self._Resolve(messages, notes, self._DetectedInCamera)

    def InWorld(
        self, messages: Sequence[Stamped[PoseSample]], notes: TopicNotes
    ) -> list[Stamped[PoseSample]]:
        """Returns true poses that are X_WO; see InCamera."""
        if not self._reference:
            return list(messages)
        return self._Resolve(messages, notes, self._TrueInWorld)

    def _FindCamera(self) -> RigidTransform | None:
        frame = self._camera_frame
        if not frame or not self._reference:
            return None
        if not self._tree.Connects(frame, self._reference):
            self._notes.Add(
                f"tf doesn't say where the camera's frame {frame!r} is in "
                f"{self._reference!r}: it is taken to be where the scene says"
            )
            return None
        times = self._tree.SampleTimes(frame, self._reference)
        if not len(times):
            times = np.zeros(1, dtype=np.int64)
        q, p = self._FromReference(
            self._tree.Resolve(frame, self._reference, times)
        )
        poses = np.hstack([q, p])
        poses = poses[np.all(np.isfinite(poses), axis=1)]
        if not len(poses):
            return None
        mean = mean_pose(poses, np.full(len(poses), 1 / len(poses)))
        self._CheckThatCameraRests(poses, mean)
        # A static pose is kept to the bit.
        return rigid_transform(poses[0] if len(poses) == 1 else mean)

    def _CheckThatCameraRests(
        self, poses: np.ndarray, mean: np.ndarray
    ) -> None:
        distance = np.linalg.norm(poses[:, 4:] - mean[4:], axis=1).max()
        angle = angle_between(poses[:, :4], mean[:4]).max()
        if distance > _MAX_CAMERA_MOTION[0] or angle > _MAX_CAMERA_MOTION[1]:
            self._notes.Add(
                f"the camera moves, by up to {distance:.3f} m and {angle:.3f} "
                "rad from its mean pose: visibility is that from the mean "
                "pose; poses in the world are not affected"
            )

    def _Resolve(
        self,
        messages: Sequence[Stamped[PoseSample]],
        notes: TopicNotes,
        resolve: Callable[[str, np.ndarray, PoseArrays], PoseArrays],
    ) -> list[Stamped[PoseSample]]:
        """Returns the messages with the poses that ``resolve`` returns.

        ``resolve`` is called once for every frame. It gets the frame's name,
        and the times (in nanoseconds) and poses of the messages in it.
        """
        by_frame: dict[str, list[Stamped[PoseSample]]] = {}
        for m in messages:
            if is_usable_pose(m.value, notes):
                by_frame.setdefault(m.value.frame, []).append(m)
        placed: list[Stamped[PoseSample]] = []
        for frame, group in by_frame.items():
            reason = (
                f"in the frame {frame!r}, which nothing connects to "
                f"{self._reference!r} at that time"
            )
            times = np.array([m.time for m in group], dtype=np.int64)
            q, p = resolve(frame, times, _poses(group))
            for i, m in enumerate(group):
                if np.all(np.isfinite(p[i])):
                    pose = replace(m.value, q=q[i], p=p[i])
                    placed.append(replace(m, value=pose))
                else:
                    notes.CountLeftOut(reason)
        return sorted(placed, key=lambda m: m.received)

    def _DetectedInCamera(
        self, frame: str, times: np.ndarray, own: PoseArrays
    ) -> PoseArrays:
        if self.X_WC is None and frame == self._camera_frame:
            return own
        X_CW = _constant(self._camera.inverse(), len(times))
        return compose(X_CW, self._WorldPoses(self._tree, frame, times, own))

    def _TrueInWorld(
        self, frame: str, times: np.ndarray, own: PoseArrays
    ) -> PoseArrays:
        if self._base is not None:
            return self._WorldPoses(self._base, _CAPTURE, times, own)
        return self._WorldPoses(self._tree, frame, times, own)

    def _WorldPoses(
        self,
        tree: TransformTree,
        frame: str,
        times: np.ndarray,
        own: PoseArrays,
    ) -> PoseArrays:
        """Returns the poses in the world of what is in a frame."""
        X_RF = tree.Resolve(frame, self._reference, times)
        return compose(self._FromReference(X_RF), own)

    def _FromReference(self, X_RF: PoseArrays) -> PoseArrays:
        X_WR = _constant(self._topics.ReferencePose(), len(X_RF[0]))
        return compose(X_WR, X_RF)


def _base_tree(
    base: Sequence[Stamped[PoseSample]], reference: str, notes: LogNotes
) -> TransformTree | None:
    if not base:
        return None
    named = [
        replace(m, value=replace(m.value, frame=_CAPTURE, name=reference))
        for m in base
    ]
    return make_transform_tree(named, (), notes=notes)


def _poses(messages: Sequence[Stamped[PoseSample]]) -> PoseArrays:
    poses = [m.value for m in messages]
    return np.array([unit(s.q) for s in poses]), np.array([s.p for s in poses])


def _constant(pose: RigidTransform, count: int) -> PoseArrays:
    row = pose_array(pose)
    return np.tile(row[:4], (count, 1)), np.tile(row[4:], (count, 1))
