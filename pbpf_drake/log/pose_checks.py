"""Which poses of a log can be used."""

import math

import numpy as np

from pbpf_drake.bags.log_notes import TopicNotes
from pbpf_drake.log.log_samples import PoseSample

# Nothing is further away (in meters): the number is damaged.
_MAX_POSITION = 1e6


def is_usable_pose(pose: PoseSample, notes: TopicNotes) -> bool:
    """Tells if a pose can be used; counts what is wrong with it."""
    norm = math.hypot(*pose.q)  # Unlike numpy's, without overflow.
    if not np.all(np.isfinite(pose.p)):
        notes.CountLeftOut("whose position is not finite")
    elif np.abs(pose.p).max() > _MAX_POSITION:
        notes.CountLeftOut(f"that is more than {_MAX_POSITION:g} m away")
    elif not math.isfinite(norm):
        notes.CountLeftOut("whose quaternion is not finite")
    elif norm < 1e-6:
        notes.CountLeftOut("whose quaternion is zero")
    else:
        if abs(norm - 1) > 0.1:
            notes.Count(
                "normalized",
                "whose quaternion's length is off by more than 10 %",
            )
        return True
    return False


def unit(q: np.ndarray) -> np.ndarray:
    """Returns a quaternion (4,) scaled to unit length."""
    norm = math.hypot(*q)
    # A unit quaternion is kept to the bit.
    return q if abs(norm - 1) < 1e-14 else q / norm
