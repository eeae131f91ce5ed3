"""Says in Python's log what of its input a filter doesn't use."""

from collections.abc import Sequence
import logging

import numpy as np

from pbpf_drake.filtering.recent_detections import DETECTION_FATES

# A reason is said once it left out more than this share of the detections ...
MAX_LEFT_OUT = 0.1
# ... and this many.
_FEW = 3
# So many outliers in a row are said; the track may be lost.
MANY_REJECTED = 5
_REMEDIES = {
    "too old": "raise filter.max_detection_age, or see whether the camera's "
    "clock is behind",
    "of the future": "detections and joints need stamps of the same clock",
    "older than the one before": "they have to arrive in the order of their "
    "images",
    "not finite, or too far away": "poses are expected in the world, in "
    "meters, and not far from the scene's models",
}


class InputWarnings:
    """Warns of what is left out, once for each object and reason.

    Args:
        object_names: of the K objects.
        joint_names: of the n joints; by default their numbers.
    """

    def __init__(
        self, object_names: Sequence[str], joint_names: Sequence[str]
    ) -> None:
        self._object_names = tuple(object_names)
        self._joint_names = tuple(joint_names)
        self._said: set[tuple[str, str]] = set()

    def CheckJoints(self, positions: np.ndarray) -> None:
        """Warns of joints that have never had a finite position.

        Args:
            positions: (n,) NaN where there was none yet.
        """
        missing = [
            name
            for name, q in zip(
                self._joint_names or range(len(positions)),
                positions,
                strict=True,
            )
            if not np.isfinite(q)
        ]
        if missing:
            self._SayOnce(
                ("joints", str(missing)),
                f"The joints {missing} have no finite position yet: nothing "
                "is tracked until they have",
            )

    def CheckDetections(
        self, counts: np.ndarray, num_rejected: np.ndarray
    ) -> None:
        """Warns of detections that aren't used, or have no effect.

        Args:
            counts: (K, 5) see RecentDetections.
            num_rejected: (K,) see FilterState.
        """
        for k, name in enumerate(self._object_names):
            for reason, count in list(
                zip(DETECTION_FATES, counts[k], strict=True)
            )[1:]:
                if count > max(_FEW, MAX_LEFT_OUT * counts[k].sum()):
                    self._SayOnce(
                        (name, reason),
                        f"{name}: {count:.0f} of {counts[k].sum():.0f} "
                        f"detections were not used, because they are {reason}; "
                        f"{_REMEDIES[reason]}",
                    )
            if num_rejected[k] >= MANY_REJECTED:
                self._SayOnce(
                    (name, "rejected"),
                    f"{name}: the last {num_rejected[k]:.0f} detections are "
                    "far from all particles, and have no effect: the track may "
                    "be lost, or the detections wrong; see "
                    "filter.recover_lost_tracks",
                )
            elif num_rejected[k] == 0:
                self._said.discard((name, "rejected"))

    def _SayOnce(self, key: tuple[str, str], text: str) -> None:
        if key not in self._said:
            self._said.add(key)
            logging.getLogger(__name__).warning(text)
