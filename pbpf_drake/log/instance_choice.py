"""Which of several detections of a class in one image is the tracked object.

A detector sees every object of a class, and can't tell which one is tracked.
"""

from collections.abc import Sequence

import numpy as np

from pbpf_drake.bags.log_notes import TopicNotes
from pbpf_drake.log.log_samples import PoseSample, Stamped

# Scores that are less than the highest one by up to this share are as good.
_MARGIN = 0.1


def one_instance(
    messages: Sequence[Stamped[PoseSample]],
    expected: np.ndarray | None,
    notes: TopicNotes,
) -> list[Stamped[PoseSample]]:
    """Returns one detection of each image, in the order given.

    It is that of the highest score. Of several scores that are about as high it
    is the one nearest to the object's detection before, or, before any, to
    where it is expected. A detection that is there twice is kept twice: it
    isn't another instance.

    Args:
        messages: poses X_CO of one class.
        expected: (3,) where the object is at first, in the same frame (in
            meters); None where that isn't known.
        notes: counts what is left out.
    """
    by_time: dict[int, list[int]] = {}
    for i, message in enumerate(messages):
        by_time.setdefault(message.time, []).append(i)
    kept: list[int] = []
    last = expected
    for time in sorted(by_time):
        group = by_time[time]
        best = _choose([messages[i].value for i in group], last)
        last = best.p
        for i in group:
            if _is_same(messages[i].value, best):
                kept.append(i)
            else:
                notes.CountLeftOut(_reason(messages[i].value, best))
    return [messages[i] for i in sorted(kept)]


def _choose(poses: Sequence[PoseSample], last: np.ndarray | None) -> PoseSample:
    """Returns the pose to use."""
    scores = np.array([pose.score for pose in poses])
    # A score that isn't a number is as good as none.
    scores = np.nan_to_num(scores, posinf=0.0, neginf=0.0)
    if last is None:
        return poses[int(scores.argmax())]
    least = scores.max() - _MARGIN * abs(scores.max())
    good = [p for p, s in zip(poses, scores, strict=True) if s >= least]
    return min(good, key=lambda pose: float(np.linalg.norm(pose.p - last)))


def _is_same(a: PoseSample, b: PoseSample) -> bool:
    return np.array_equal(a.p, b.p) and np.array_equal(a.q, b.q)


def _reason(left: PoseSample, used: PoseSample) -> str:
    if left.score < used.score:
        why = "with a higher score"
    else:
        why = "that is nearer to where it was before"
    return f"for another instance of the class in the same image {why}"
