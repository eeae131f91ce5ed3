"""How many particles fit into a period, by how long the last updates took."""

from collections import deque

# Updates that count; a single one that took long doesn't.
_UPDATES = 3
# Of the period, that an update may take.
_SHARE = 0.8


class UpdatePace:
    """Measures the time per particle.

    An update has a part that doesn't depend on the number of particles. It is
    shared out among them. Then the number that fits is approached within a few
    updates, from below and from above.

    Args:
        period: between two updates (in seconds).
    """

    def __init__(self, period: float) -> None:
        self._budget = _SHARE * period
        self._per_particle: deque[float] = deque(maxlen=_UPDATES)

    def AddUpdate(self, seconds: float, count: int) -> None:
        """Adds an update to the last ones.

        Args:
            seconds: how long it took.
            count: how many particles it had.
        """
        self._per_particle.append(seconds / count)

    def MaxParticles(self) -> int | None:
        """Returns how many particles fit; None as long as that isn't known."""
        if not self._per_particle:
            return None
        # Of an even number, the larger of the two in the middle.
        median = sorted(self._per_particle)[len(self._per_particle) // 2]
        return max(1, int(self._budget / max(median, 1e-9)))
