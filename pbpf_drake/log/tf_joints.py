"""Joint positions that are coordinates of tf frames."""

from collections.abc import Collection, Sequence

import numpy as np

from pbpf_drake.bags.log_error import LogError
from pbpf_drake.config.log_topics import LogTopics, frame_name
from pbpf_drake.log.log_samples import JointSample, Stamped
from pbpf_drake.log.transform_tree import TransformTree
from pbpf_drake.poses.quaternions import rotate


def tf_joint_samples(
    tree: TransformTree, topics: LogTopics, names: Sequence[str]
) -> list[Stamped[JointSample]]:
    """Returns samples of the joints that ``topics.tf_joints`` names.

    There is one whenever a frame on the way to the reference frame was
    measured. The coordinates are those in the world.

    Args:
        tree: what tf says.
        topics: names the frames.
        names: of the robot's joints.

    Raises:
        LogError: a joint is missing, or tf doesn't say where it is.
    """
    if set(topics.tf_joints) != set(names):
        raise LogError(
            f"the scene's topics.tf_joints names {sorted(topics.tf_joints)}; "
            f"expected the robot's joints {list(names)}"
        )
    columns = [_coordinate(topics.tf_joints[name]) for name in names]
    # In this order, so that the same log always gets the same error.
    frames = list(dict.fromkeys(frame for frame, _ in columns))
    reference = frame_name(topics.reference_frame)
    times = _sample_times(tree, frames, reference)
    X_WR = topics.ReferencePose()
    q_WR = X_WR.rotation().ToQuaternion().wxyz()
    positions = {}
    for frame in frames:
        _, p_RF = tree.Resolve(frame, reference, times)
        positions[frame] = X_WR.translation() + rotate(q_WR, p_RF)
    rows = np.column_stack([positions[f][:, axis] for f, axis in columns])
    return [
        Stamped(int(time), int(time), JointSample(tuple(names), row, ()))
        for time, row in zip(times, rows, strict=True)
        if np.all(np.isfinite(row))
    ]


def _coordinate(text: str) -> tuple[str, int]:
    """Returns the frame and the axis of "frame.x"."""
    frame, _, axis = text.rpartition(".")
    return frame_name(frame), "xyz".index(axis)


def _sample_times(
    tree: TransformTree, frames: Collection[str], reference: str
) -> np.ndarray:
    for frame in frames:
        if not tree.Connects(frame, reference):
            raise LogError(
                f"tf doesn't connect the frame {frame!r}, which the scene's "
                f"topics.tf_joints names, to {reference!r}; the frames are "
                f"{sorted(tree.motions)}"
            )
    times = [tree.SampleTimes(frame, reference) for frame in frames]
    return np.unique(np.concatenate(times))
