"""Tells of updates that take longer than the period."""

from collections.abc import Callable
import logging
import time as wall_clock

# Between two lines in the log (in seconds).
_PAUSE = 5.0


class LateUpdates:
    """Counts late updates, and warns of them in Python's log.

    A late update is one that takes longer than the period. The estimate is
    that much older when it comes, and the next update begins later. There is
    at most one line in five seconds.

    ``AddUpdate`` can be the filter's ``on_update``.

    Args:
        period: of the filter (in seconds).
        clock: returns a time (in seconds).
    """

    def __init__(
        self,
        period: float,
        *,
        clock: Callable[[], float] = wall_clock.monotonic,
    ) -> None:
        self._period = period
        self._clock = clock
        self._next_line = -float("inf")
        self.updates = 0
        self.late = 0

    def AddUpdate(self, seconds: float) -> None:
        """Adds an update that took so long (in seconds)."""
        self.updates += 1
        if seconds <= self._period:
            return
        self.late += 1
        if self._clock() < self._next_line:
            return
        self._next_line = self._clock() + _PAUSE
        logging.getLogger(__name__).warning(
            "A filter update took %.0f ms, longer than the period of %.0f ms; "
            "%d of %d updates were late",
            1e3 * seconds,
            1e3 * self._period,
            self.late,
            self.updates,
        )
