"""How old detections are when they arrive."""

import numpy as np

# A larger share of detections of this kind is worth a warning.
_MAX_SHARE = 0.1
# Stamps that are later than the recording by more are of a clock that is ahead
# (in seconds).
_MAX_AHEAD = 0.05


def age_summary(ages: np.ndarray) -> str:
    """Returns a clause on how old detections are.

    Args:
        ages: (N,) from the image's stamp to when they were received (in
            seconds); at least one.
    """
    median, high = np.percentile(ages, [50, 95])
    return (
        f"{median:.3f} s old when they arrive (median; 95th percentile "
        f"{high:.3f} s)"
    )


def age_warning(
    times: np.ndarray, received: np.ndarray, *, period: float, max_age: float
) -> str:
    """Returns a clause if too many detections are too old; otherwise nothing.

    Args:
        times: (N,) stamps of the images (in seconds).
        received: (N,) when the detections arrived (in seconds).
        period: time between updates of the filter, the first of which is at 0
            (in seconds).
        max_age: from which on detections aren't used (in seconds).
    """
    # At each update that has new detections, the newest one counts.
    newest: dict[int, float] = {}
    updates = np.ceil(received / period - 1e-9).astype(int)
    for update, time in zip(updates.tolist(), times.tolist(), strict=True):
        newest[update] = max(time, newest.get(update, -np.inf))
    old = sum(
        update * period - time > max_age + 1e-9
        for update, time in newest.items()
    )
    if old <= _MAX_SHARE * len(newest):
        return ""
    return (
        f"at {old} of {len(newest)} updates of the filter that get new ones, "
        f"the newest is older than filter.max_detection_age, {max_age:g} s: "
        f"they are {age_summary(received - times)}, as the detector is slow "
        "or the camera's clock is behind; raise filter.max_detection_age, or "
        "correct the stamps"
    )


def ahead_warning(ahead: np.ndarray) -> str:
    """Returns a clause if a camera's clock is ahead; otherwise nothing.

    Args:
        ahead: (N,) from when the detections were recorded to their stamps (in
            seconds).
    """
    early = np.count_nonzero(ahead > _MAX_AHEAD)
    if early <= _MAX_SHARE * len(ahead):
        return ""
    return (
        f"{early} of {len(ahead)} have stamps later than they were recorded, "
        f"by {np.median(ahead[ahead > _MAX_AHEAD]):.3f} s (median): the "
        "camera's clock is ahead; they are used at their stamps"
    )
