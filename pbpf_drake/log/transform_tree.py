"""Resolves a tree of coordinate frames, as ROS's tf does.

Every frame but the root has one parent, and its pose in it is either static
or a recorded motion. Poses are resolved for many times at once.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.log.log_samples import PoseSample, Stamped
from pbpf_drake.log.pose_interpolation import find_segments, interpolate_poses
from pbpf_drake.poses.quaternions import conjugate, multiply, normalize, rotate

# Of N poses: (N, 4) unit quaternions w, x, y, z, and (N, 3) in meters.
PoseArrays = tuple[np.ndarray, np.ndarray]

# How far from a sample the pose of a moving frame is still known (in
# nanoseconds): between two samples, and before the first or after the last one.
_MAX_GAP = 500_000_000
_MAX_HOLD = 100_000_000


@dataclass(frozen=True)
class FrameMotion:
    """The pose of one frame in its parent.

    Attributes:
        parent: the other frame.
        times: (N,) strictly increasing (in nanoseconds).
        q, p: (N, 4) unit quaternions w, x, y, z, and (N, 3) in meters.
        static: whether the pose holds at all times.
    """

    parent: str
    times: np.ndarray
    q: np.ndarray
    p: np.ndarray
    static: bool

    def At(self, times: np.ndarray) -> PoseArrays:
        """Returns q (T, 4) and p (T, 3); NaN where it isn't known."""
        if self.static:
            count = len(times)
            return np.tile(self.q[-1], (count, 1)), np.tile(
                self.p[-1], (count, 1)
            )
        # Nanoseconds since the epoch are too many for a double.
        start = self.times[0]
        own, asked = (self.times - start) / 1e9, (times - start) / 1e9
        q, p = interpolate_poses(PoseRecord(own, self.q, self.p), asked)
        i, j, _ = find_segments(own, asked)
        distance = np.minimum(
            np.abs(times - self.times[i]), np.abs(times - self.times[j])
        )
        within = (times >= start) & (times <= self.times[-1])
        unknown = distance > np.where(within, _MAX_GAP, _MAX_HOLD)
        q[unknown], p[unknown] = np.nan, np.nan
        return q, p


class TransformTree:
    """Frames and their motions.

    Attributes:
        motions: by the frame's name.
    """

    def __init__(self, motions: Mapping[str, FrameMotion]):
        """Makes a tree.

        Args:
            motions: by the frame's name.
        """
        self.motions = dict(motions)

    def Path(self, frame: str) -> list[str]:
        """Returns a frame and all above it, up to the root."""
        path = [frame]
        while path[-1] in self.motions:
            parent = self.motions[path[-1]].parent
            if parent in path:
                break  # A loop has no root; what is in it is unconnected.
            path.append(parent)
        return path

    def Connects(self, frame: str, reference: str) -> bool:
        """Tells if there is a way from one frame to another."""
        return self._CommonAncestor(frame, reference) is not None

    def _CommonAncestor(self, frame: str, reference: str) -> str | None:
        others = self.Path(reference)
        return next((f for f in self.Path(frame) if f in others), None)

    def SampleTimes(self, frame: str, reference: str) -> np.ndarray:
        """Returns when the pose of a frame in another was measured.

        Returns:
            (T,) sorted (in nanoseconds): the samples of all motions between
            the two; empty if they are static or not connected.
        """
        common = self._CommonAncestor(frame, reference)
        if common is None:
            return np.zeros(0, dtype=np.int64)
        up, down = self.Path(frame), self.Path(reference)
        between = up[: up.index(common)] + down[: down.index(common)]
        times = [
            self.motions[f].times for f in between if not self.motions[f].static
        ]
        return np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *times]))

    def Resolve(
        self, frame: str, reference: str, times: np.ndarray
    ) -> PoseArrays:
        """Returns the poses of a frame in another at given times.

        Args:
            frame: whose pose.
            reference: in what.
            times: (T,) (in nanoseconds).

        Returns:
            q (T, 4) as w, x, y, z and p (T, 3) in meters; NaN where the two
            aren't connected at that time.
        """
        common = self._CommonAncestor(frame, reference)
        if common is None:
            count = len(times)
            return np.full((count, 4), np.nan), np.full((count, 3), np.nan)
        return compose(
            inverse(self._InAncestor(reference, common, times)),
            self._InAncestor(frame, common, times),
        )

    def _InAncestor(
        self, frame: str, ancestor: str, times: np.ndarray
    ) -> PoseArrays:
        pose = identity(len(times))
        while frame != ancestor:
            pose = compose(self.motions[frame].At(times), pose)
            frame = self.motions[frame].parent
        return pose


def identity(count: int) -> PoseArrays:
    """Returns q (count, 4) and p (count, 3) of no motion."""
    return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1)), np.zeros((count, 3))


def compose(X_AB: PoseArrays, X_BC: PoseArrays) -> PoseArrays:
    """Returns X_AC, as q (..., 4) and p (..., 3)."""
    q = multiply(X_AB[0], X_BC[0])
    return q, X_AB[1] + rotate(X_AB[0], X_BC[1])


def inverse(
    X_AB: PoseArrays,
) -> PoseArrays:
    """Returns X_BA, as q (..., 4) and p (..., 3)."""
    q = conjugate(X_AB[0])
    return q, -rotate(q, X_AB[1])


def make_transform_tree(
    moving: Sequence[Stamped[PoseSample]],
    static: Sequence[PoseSample],
    *,
    notes: LogNotes,
) -> TransformTree:
    """Returns the tree that tf messages tell of.

    A frame that never moves is taken as static, whatever topic it is on.

    Args:
        moving: usable poses of frames in their parents, as they were
            received.
        static: those that hold at all times; the last one of a frame counts.
        notes: says where a frame has two parents.
    """
    by_name: dict[str, list[Stamped[PoseSample]]] = {}
    for message in moving:
        by_name.setdefault(message.value.name, []).append(message)
    motions = {
        name: _motion(name, samples, notes) for name, samples in by_name.items()
    }
    for pose in static:
        q, p = normalize(pose.q)[np.newaxis], pose.p[np.newaxis]
        motions[pose.name] = FrameMotion(
            pose.frame, np.zeros(1, dtype=np.int64), q, p, True
        )
    return TransformTree(motions)


def _motion(
    name: str, samples: Sequence[Stamped[PoseSample]], notes: LogNotes
) -> FrameMotion:
    parents = Counter(sample.value.frame for sample in samples)
    ((parent, count),) = parents.most_common(1)
    if len(parents) > 1:
        notes.Add(
            f"tf: the frame {name} has the parents {sorted(parents)}; used "
            f"{parent} and left out {len(samples) - count} transforms"
        )
    # Of equal stamps the last one counts.
    by_time = {s.time: s.value for s in samples if s.value.frame == parent}
    times = sorted(by_time)
    q = normalize(np.array([by_time[t].q for t in times]))
    p = np.array([by_time[t].p for t in times])
    static = bool(np.all(q == q[0]) and np.all(p == p[0]))
    return FrameMotion(parent, np.array(times, dtype=np.int64), q, p, static)
