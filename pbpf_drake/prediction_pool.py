"""One simulator per particle, and the threads that run them.

The pool is scratch space: every call sets everything that it depends on, so
it has no memory, and a copy of it is simply an empty one.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from pydrake.systems.analysis import Simulator

# Which links of the robot a simulator has.
Links = tuple[int, ...]
# Simulators are kept for this many sets of links.
_MAX_LINKS = 4


class PredictionPool:
    """Holds a simulator for each particle; made at first use.

    Args:
        make: makes a simulator, of some links and of a particle's index.
        num_threads: how many threads run them.
    """

    def __init__(
        self, *, make: Callable[[Links, int], Simulator], num_threads: int
    ) -> None:
        self._make = make
        self._num_threads = num_threads
        self._simulators: dict[Links, dict[int, Simulator]] = {}
        self._executor: ThreadPoolExecutor | None = None

    def __deepcopy__(self, memo: dict) -> "PredictionPool":
        return PredictionPool(make=self._make, num_threads=self._num_threads)

    def Simulators(self, links: Links) -> "Simulators":
        """Returns the simulators with these links.

        Those that were not asked for the longest may be given up.
        """
        kept = self._simulators.pop(links, {})
        self._simulators[links] = kept
        while len(self._simulators) > _MAX_LINKS:
            self._simulators.pop(next(iter(self._simulators)))
        return Simulators(lambda index: self._make(links, index), kept)

    def Run(self, work: Callable[[int], None], indices: Sequence[int]) -> None:
        """Calls ``work`` for every index, spread over the threads."""
        if self._num_threads == 1:
            for index in indices:
                work(index)
            return
        if self._executor is None:
            self._executor = ThreadPoolExecutor(self._num_threads)
        rest = iter(indices)  # Whoever is done takes the next.

        def run() -> None:
            for index in rest:
                work(index)

        runs = [self._executor.submit(run) for _ in range(self._num_threads)]
        for future in runs:
            future.result()


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
