"""Work space of a filter's context."""

from collections.abc import Sequence
from typing import Generic

from pbpf_drake.filtering.input_warnings import InputWarnings
from pbpf_drake.filtering.particle_filter_update import (
    ParticleFilterUpdate,
    UpdateScratch,
)
from pbpf_drake.filtering.update_pace import UpdatePace
from pbpf_drake.motion.motion_model import MotionScratch


class FilterScratch(Generic[MotionScratch]):
    """The update's work space, how long updates took, what was warned of.

    No result depends on it, but for ``adaptive_count.to_period``. A copy is
    empty: a context that is cloned gets contexts and processes of its own.

    Args:
        update: the algorithm.
        period: between two updates (in seconds).
        object_names: to warn of detections.
        joint_names: to warn of joints.
    """

    def __init__(
        self,
        update: ParticleFilterUpdate[MotionScratch],
        period: float,
        object_names: Sequence[str] = (),
        joint_names: Sequence[str] = (),
    ) -> None:
        self._update = update
        self._period = period
        self._names = tuple(object_names), tuple(joint_names)
        self._for_update: UpdateScratch[MotionScratch] | None = None
        self.pace = UpdatePace(period)
        self.warnings = InputWarnings(*self._names)

    def __deepcopy__(self, memo: dict) -> "FilterScratch[MotionScratch]":
        return FilterScratch(self._update, self._period, *self._names)

    def ForUpdate(self) -> UpdateScratch[MotionScratch]:
        """Returns what the update works in, made at first use."""
        if self._for_update is None:
            self._for_update = self._update.MakeScratch()
        return self._for_update
