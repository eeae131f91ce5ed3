"""Measures how much faster independent processes are on this machine.

Two virtual cores may be two threads of one core, and other programs may use
them, too. So the best that the filter can reach with more processes is what
processes reach that share nothing and only compute, measured in the same run.
"""

import multiprocessing
from multiprocessing.queues import SimpleQueue
from multiprocessing.synchronize import Barrier
from statistics import median
from time import perf_counter

_WORK = 1_000_000


def MeasureProcessSpeedup(count: int, *, rounds: int = 7) -> float:
    """Returns how many times as much processes compute per second as one.

    In each round, one of them computes alone, and then all of them do. The
    result is the median over the rounds.

    Args:
        count: of processes.
        rounds: how often.
    """
    context = multiprocessing.get_context("spawn")
    barrier, queue = context.Barrier(count), context.SimpleQueue()
    processes = [
        context.Process(target=_work, args=(barrier, queue, rounds, rank == 0))
        for rank in range(count)
    ]
    for process in processes:
        process.start()
    times = [[queue.get() for _ in processes] for _ in range(rounds)]
    for process in processes:
        process.join()
    return median(
        count * max(alone for alone, _ in one) / max(both for _, both in one)
        for one in times
    )


def _work(
    barrier: Barrier,
    queue: SimpleQueue[tuple[float, float]],
    rounds: int,
    is_first: bool,
) -> None:
    for _ in range(rounds):
        barrier.wait()
        alone = _compute() if is_first else 0.0
        barrier.wait()
        queue.put((alone, _compute()))


def _compute() -> float:
    """Returns how long some integer arithmetic takes (in seconds)."""
    begin = perf_counter()
    x = 1
    for _ in range(_WORK):
        x = (x * 1103515245 + 12345) % 2147483648
    return perf_counter() - begin
