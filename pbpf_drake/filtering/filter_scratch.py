"""Work space of a filter's context."""

from typing import Generic

from pbpf_drake.filtering.particle_filter_update import (
    ParticleFilterUpdate,
    UpdateScratch,
)
from pbpf_drake.filtering.update_pace import UpdatePace
from pbpf_drake.motion.motion_model import MotionScratch


class FilterScratch(Generic[MotionScratch]):
    """The update's work space, and how long the last updates took.

    No result depends on it, but for ``adaptive_count.to_period``. A copy is
    empty: a context that is cloned gets contexts and processes of its own.

    Args:
        update: the algorithm.
        period: between two updates (in seconds).
    """

    def __init__(
        self, update: ParticleFilterUpdate[MotionScratch], period: float
    ) -> None:
        self._update = update
        self._period = period
        self._for_update: UpdateScratch[MotionScratch] | None = None
        self.pace = UpdatePace(period)

    def __deepcopy__(self, memo: dict) -> "FilterScratch[MotionScratch]":
        return FilterScratch(self._update, self._period)

    def ForUpdate(self) -> UpdateScratch[MotionScratch]:
        """Returns what the update works in, made at first use."""
        if self._for_update is None:
            self._for_update = self._update.MakeScratch()
        return self._for_update
