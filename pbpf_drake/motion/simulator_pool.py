"""One simulator for each draw of θ and each set of links that is near.

Nothing of what a simulator did before may count: whoever uses one sets all that
the result depends on.
"""

from collections.abc import Callable

from pydrake.systems.analysis import Simulator

from pbpf_drake.motion.robot_links import LinkSet

# Simulators are kept for this many sets of links.
_MAX_LINK_SETS = 4


class SimulatorPool:
    """Keeps simulators, which are made when first used.

    Args:
        make: makes the simulator of a set of links and a draw of θ.
    """

    def __init__(self, make: Callable[[LinkSet, int], Simulator]) -> None:
        self._make = make
        self._simulators: dict[LinkSet, dict[int, Simulator]] = {}

    def Simulators(self, link_set: LinkSet) -> "Simulators":
        """Returns the simulators with these links.

        If there are simulators for too many sets of links, those of the set
        that was asked for the longest ago are given up.
        """
        kept = self._simulators.pop(link_set, {})
        self._simulators[link_set] = kept
        while len(self._simulators) > _MAX_LINK_SETS:
            self._simulators.pop(next(iter(self._simulators)))
        return Simulators(lambda draw: self._make(link_set, draw), kept)


class Simulators:
    """The simulators of all draws of θ, with the same links.

    Args:
        make: makes the simulator of a draw.
        kept: those that were made before, by draw; new ones are added.
    """

    def __init__(
        self, make: Callable[[int], Simulator], kept: dict[int, Simulator]
    ) -> None:
        self._make = make
        self._kept = kept

    def Get(self, draw: int) -> Simulator:
        """Returns the simulator of a draw."""
        if draw not in self._kept:
            self._kept[draw] = self._make(draw)
        return self._kept[draw]

    def Discard(self, draw: int) -> None:
        """Gives up the simulator of a draw; Get makes a new one."""
        self._kept.pop(draw, None)
