"""One simulator per particle, for each set of links that is near.

The pool is scratch space: every call sets everything that it depends on, so
it has no memory.
"""

from collections.abc import Callable

from pydrake.systems.analysis import Simulator

# Which links of the robot a simulator has.
Links = tuple[int, ...]
# Simulators are kept for this many sets of links.
_MAX_LINKS = 4


class PredictionPool:
    """Holds a simulator for each particle; made at first use.

    Args:
        make: makes a simulator, of some links and of a particle's index.
    """

    def __init__(self, make: Callable[[Links, int], Simulator]) -> None:
        self._make = make
        self._simulators: dict[Links, dict[int, Simulator]] = {}

    def Simulators(self, links: Links) -> "Simulators":
        """Returns the simulators with these links.

        Those that were not asked for the longest may be given up.
        """
        kept = self._simulators.pop(links, {})
        self._simulators[links] = kept
        while len(self._simulators) > _MAX_LINKS:
            self._simulators.pop(next(iter(self._simulators)))
        return Simulators(lambda index: self._make(links, index), kept)


class Simulators:
    """The simulators of all particles, with the same links.

    Args:
        make: makes the simulator of a particle, by its index.
        kept: those that were made before; extended.
    """

    def __init__(
        self, make: Callable[[int], Simulator], kept: dict[int, Simulator]
    ) -> None:
        self._make = make
        self._kept = kept

    def Get(self, index: int) -> Simulator:
        """Returns the simulator of a particle."""
        if index not in self._kept:
            self._kept[index] = self._make(index)
        return self._kept[index]

    def Discard(self, index: int) -> None:
        """Makes the particle's next simulator a new one."""
        self._kept.pop(index, None)
