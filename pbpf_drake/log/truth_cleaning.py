"""Makes the record of an object's true poses, without what can't be used."""

from collections.abc import Sequence

import numpy as np

from pbpf_drake.bags.log_notes import TopicNotes
from pbpf_drake.log.log_jumps import without_jumps
from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.log.log_samples import PoseSample, Stamped
from pbpf_drake.log.pose_checks import is_usable_pose, unit
from pbpf_drake.log.stamp_order import in_stamp_order, seconds_since


def make_pose_record(
    messages: Sequence[Stamped[PoseSample]], *, start: int, notes: TopicNotes
) -> PoseRecord | None:
    """Returns the ground truth of one object, or None if there is none.

    Args:
        messages: poses X_WO, as they were received.
        start: what the record's times are relative to (in nanoseconds).
        notes: counts what is left out.
    """
    kept = [m for m in messages if is_usable_pose(m.value, notes)]
    if not kept:
        return None
    kept = in_stamp_order(kept, notes)
    kept = without_jumps(kept, np.array([m.value.p for m in kept]), notes)
    return PoseRecord(
        times=seconds_since(start, kept),
        q_WO=np.array([unit(m.value.q) for m in kept]),
        p_WO=np.array([m.value.p for m in kept]),
    )
