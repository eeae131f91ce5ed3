"""Runs many jobs on any executor, even if some of them fail or die."""

from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    wait,
)
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

Output = TypeVar("Output")

# A job whose process dies so often while it runs alone has failed.
_ATTEMPTS = 2


@dataclass(frozen=True, eq=False)
class Job(Generic[Output]):
    """Something to compute.

    Attributes:
        name: what to call it.
        function: what to compute; other processes import it.
        arguments: of the function.
        cost: how long it takes, in any unit.
    """

    name: str
    function: Callable[..., Output]
    arguments: tuple[Any, ...]
    cost: float = 1.0


@dataclass(frozen=True)
class Failure:
    """A job that has no result, and why."""

    name: str
    reason: str


# Makes an executor, to be used in a with statement.
ExecutorFactory = Callable[[], AbstractContextManager[Executor]]


def RunJobs(
    jobs: Sequence[Job[Output]],
    make_executor: ExecutorFactory,
    *,
    ahead: int,
    on_done: Callable[[Job[Output], Output], None],
    on_failure: Callable[[Job[Output], str], None],
) -> None:
    """Runs all jobs; one that fails doesn't stop the others.

    If a process dies, the executor of concurrent.futures is broken, and nobody
    knows which job it was. A cluster that loses its scheduler cancels all jobs
    that it was given. In both cases a new executor is made, and the jobs that
    were running run again, one at a time, so that a deadly job dies alone.

    Args:
        jobs: what to run, in this order.
        make_executor: called at the start, and whenever one is broken.
        ahead: how many jobs are handed over at a time. At least as many as
            there are workers, or some are idle.
        on_done: called with a job and its result, as soon as there is one.
        on_failure: called with a job and why it has none.

    Raises:
        Exception: whatever make_executor or on_done raises.
    """
    waiting, suspects = deque(jobs), deque[Job[Output]]()
    deaths: dict[Job[Output], int] = {}
    while waiting or suspects:
        queue, limit = (suspects, 1) if suspects else (waiting, ahead)
        with make_executor() as executor:
            lost = _drain(queue, executor, limit, on_done, on_failure)
        for job, reason in lost.items():
            if limit == 1:
                deaths[job] = deaths.get(job, 0) + 1
            if deaths.get(job, 0) >= _ATTEMPTS:
                on_failure(job, reason)
            else:
                suspects.append(job)


def _drain(
    queue: deque[Job[Output]],
    executor: Executor,
    limit: int,
    on_done: Callable[[Job[Output], Output], None],
    on_failure: Callable[[Job[Output], str], None],
) -> dict[Job[Output], str]:
    """Runs a queue until it is empty or the executor is lost.

    Returns:
        The jobs that were running when the executor was lost, and why.
    """
    running: dict[Future[Output], Job[Output]] = {}
    lost: dict[Job[Output], str] = {}
    try:
        while running or (queue and not lost):
            while queue and len(running) < limit and not lost:
                job = queue.popleft()
                try:
                    future = executor.submit(job.function, *job.arguments)
                except Exception as error:
                    # Each executor has its own error for being lost.
                    lost[job] = _describe(error)
                else:
                    running[future] = job
            done, _ = wait(running, return_when=FIRST_COMPLETED)
            for future in done:
                job = running.pop(future)
                try:
                    result = future.result()
                except BrokenExecutor:
                    lost[job] = "the process that ran it died"
                except CancelledError:
                    lost[job] = "what ran it was lost"
                except Exception as error:
                    on_failure(job, _describe(error))
                else:
                    on_done(job, result)
    except BaseException:
        # Nobody needs the results of those that haven't started yet.
        for future in running:
            future.cancel()
        raise
    return lost


def _describe(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"
