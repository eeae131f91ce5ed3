"""Makes the records of detections, without what can't be used."""

from collections.abc import Mapping, Sequence

from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform

from pbpf_drake.bags.log_notes import TopicNotes
from pbpf_drake.log.log_records import DetectionRecord
from pbpf_drake.log.log_samples import PoseSample, Stamped
from pbpf_drake.log.pose_checks import is_usable_pose, unit
from pbpf_drake.log.stamp_order import in_stamp_order


def make_detection_records(
    messages: Sequence[Stamped[PoseSample]],
    *,
    name: str | None,
    names_by_class: Mapping[str, str],
    start: int,
    notes: TopicNotes,
) -> list[DetectionRecord]:
    """Returns the detections of one source that can be used.

    Args:
        messages: poses X_CO, as they were received.
        name: of the tracked model that all are of; None where each one's own
            name is the detector's class name of it.
        names_by_class: names of tracked models by the detector's class names.
        start: what the records' times are relative to (in nanoseconds).
        notes: counts what is left out.
    """
    by_name: dict[str, list[Stamped[PoseSample]]] = {}
    for message in messages:
        class_id = message.value.name
        owner = names_by_class.get(class_id) if name is None else name
        if owner is None:
            notes.CountLeftOut(f"of the unknown class {class_id!r}")
        elif is_usable_pose(message.value, notes):
            by_name.setdefault(owner, []).append(message)
    return [
        _record(owner, message, start)
        for owner, poses in by_name.items()
        for message in in_stamp_order(poses, notes)
    ]


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
