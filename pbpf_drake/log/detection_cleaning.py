"""Makes the records of detections, without what can't be used."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform

from pbpf_drake.bags.log_notes import TopicNotes
from pbpf_drake.log.instance_choice import one_instance
from pbpf_drake.log.log_records import DetectionRecord
from pbpf_drake.log.log_samples import PoseSample, RawStamped, Stamped
from pbpf_drake.log.pose_checks import is_usable_pose, unit
from pbpf_drake.log.stamp_order import in_stamp_order


def detections_by_object(
    messages: Sequence[RawStamped[PoseSample]],
    *,
    name: str | None,
    names_by_class: Mapping[str, str],
    notes: TopicNotes,
) -> dict[str, list[RawStamped[PoseSample]]]:
    """Returns the detections of one source by the tracked model's name.

    Args:
        messages: in the file's order.
        name: of the tracked model that all are of; None where each one's own
            name is the detector's class name of it.
        names_by_class: names of tracked models by the detector's class names.
        notes: counts what is left out.
    """
    by_name: dict[str, list[RawStamped[PoseSample]]] = {}
    for message in messages:
        class_id = message.value.name
        owner = names_by_class.get(class_id) if name is None else name
        if owner is None:
            notes.CountLeftOut(f"of the unknown class {class_id!r}")
        else:
            by_name.setdefault(owner, []).append(message)
    return by_name


def make_detection_records(
    messages: Sequence[Stamped[PoseSample]],
    *,
    name: str,
    start: int,
    expected: np.ndarray | None,
    notes: TopicNotes,
) -> list[DetectionRecord]:
    """Returns the detections of one object that can be used.

    Args:
        messages: poses X_CO, as they were received.
        name: of the tracked model.
        start: what the records' times are relative to (in nanoseconds).
        expected: (3,) where the object is at first, in the camera's frame (in
            meters); None where that isn't known.
        notes: counts what is left out.
    """
    kept = [m for m in messages if is_usable_pose(m.value, notes)]
    for message in kept:
        if message.value.is_of_bbox:
            notes.Count(
                "took from bbox.center the pose of",
                "whose results have the pose of an empty message",
            )
    kept = one_instance(kept, expected, notes)
    if not kept:
        return []
    return [_record(name, m, start) for m in in_stamp_order(kept, notes)]


def _record(
    name: str, message: Stamped[PoseSample], start: int
) -> DetectionRecord:
    pose = message.value
    return DetectionRecord(
        name=name,
        time=(message.time - start) / 1e9,
        received=(message.received - start) / 1e9,
        X_CO=RigidTransform(
            quaternion=Quaternion(*unit(pose.q).tolist()), p=pose.p
        ),
    )
