"""One simulator per particle, and the threads that run them.

The pool is scratch space: every call sets everything that it depends on, so
it has no memory, and a copy of it is simply an empty one.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from pydrake.systems.analysis import (
    ApplySimulatorConfig,
    Simulator,
    SimulatorConfig,
)

from pbpf_drake.prediction_model import PredictionModel


class PredictionPool:
    """Holds a simulator for each particle; made at first use.

    Args:
        make: makes the simulator of a particle, by its index.
        num_threads: how many threads run them.
    """

    def __init__(
        self, *, make: Callable[[int], Simulator], num_threads: int
    ) -> None:
        self._make = make
        self._num_threads = num_threads
        self._simulators: dict[int, Simulator] = {}
        self._executor: ThreadPoolExecutor | None = None

    def __deepcopy__(self, memo: dict) -> "PredictionPool":
        return PredictionPool(make=self._make, num_threads=self._num_threads)

    def Simulator(self, index: int) -> Simulator:
        """Returns the simulator of a particle."""
        if index not in self._simulators:
            self._simulators[index] = self._make(index)
        return self._simulators[index]

    def Discard(self, index: int) -> None:
        """Makes the particle's next simulator a new one."""
        self._simulators.pop(index, None)

    def Run(self, work: Callable[[int], None], indices: Sequence[int]) -> None:
        """Calls ``work`` for every index, spread over the threads."""
        if self._num_threads == 1:
            for index in indices:
                work(index)
            return
        if self._executor is None:
            self._executor = ThreadPoolExecutor(self._num_threads)
        for _ in self._executor.map(work, indices):
            pass


def MakeSimulator(model: PredictionModel, time_step: float) -> Simulator:
    """Returns a simulator with a context of its own.

    It takes fixed steps with the convex solver of Drake's CENIC integrator.
    Error control costs three times as much per step, and misses contacts
    that begin within a long one.

    Args:
        model: the prediction model, shared.
        time_step: of the integrator (in seconds).
    """
    simulator = Simulator(model.diagram, model.diagram.CreateDefaultContext())
    ResetIntegrator(simulator, time_step)
    return simulator


def ResetIntegrator(simulator: Simulator, time_step: float) -> None:
    """Gives a simulator an integrator that remembers nothing.

    CENIC takes a step that starts at the same time as its last one for a
    second attempt at that step, and reuses the state of then, even if the
    simulator was initialized in between.

    Args:
        simulator: from MakeSimulator.
        time_step: of the integrator (in seconds).
    """
    ApplySimulatorConfig(
        SimulatorConfig(
            integration_scheme="cenic",
            max_step_size=time_step,
            use_error_control=False,
        ),
        simulator,
    )
