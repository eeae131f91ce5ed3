"""Processes that share the work on the particles of an update.

Threads would hardly help: only one of them at a time can run Python. Processes
run at the same time. They are forked from this one, so they have all that it
has already, and only jobs and their results are sent between them.
"""

from collections.abc import Iterator, Sequence
import contextlib
from contextlib import AbstractContextManager
import gc
import logging
import multiprocessing
from multiprocessing.connection import Connection
from multiprocessing.context import ForkProcess
from multiprocessing.reduction import ForkingPickler
import signal
import sys
import threading
import time
from typing import Any, Generic, Protocol, TypeVar
import warnings
import weakref

import numpy as np

# In bytes.
_LARGEST_BLOCK = 31 * 2**20
# How long a process may be silent before it is ended (in seconds).
_PATIENCE = 10.0
# What a pipe holds although nobody reads it, so that writing doesn't block (in
# bytes): half of what Linux has.
_FITS_INTO_PIPE = 2**15

_Worker = TypeVar("_Worker")
_Result = TypeVar("_Result")
_WorkerOfJob = TypeVar("_WorkerOfJob", contravariant=True)
_ResultOfJob = TypeVar("_ResultOfJob", covariant=True)


class Job(Protocol[_WorkerOfJob, _ResultOfJob]):
    """Something to be done, with all that has to be known to do it.

    A job and its result may have to go to another process and back, so both
    must be possible to pickle. Arrays travel fast.
    """

    def RunOn(self, worker: _WorkerOfJob) -> _ResultOfJob:
        """Returns the result, which depends on nothing but the job."""


class Crew(Generic[_Worker]):
    """This process and copies of it, which are made when first needed.

    A copy that has died is replaced at the next call, and its jobs are done
    here. So is one that doesn't answer, because it was stopped or is starved:
    it has ten times as long as this process took for its own share, and ten
    seconds more. Copies are made on Linux only, and never by a daemonic
    process, which isn't allowed to; elsewhere this process does everything.

    Args:
        worker: what jobs are run on, e.g. an object with contexts of its own.
            Each copy of the process has a copy of it.
        size: how many processes there are, including this one.
    """

    def __init__(self, worker: _Worker, size: int) -> None:
        _keep_freed_memory()
        self._worker = worker
        self._size = size
        self._helpers: dict[int, _Helper] = {}

    @property
    def worker(self) -> _Worker:
        """What this process runs its own jobs on."""
        return self._worker

    @property
    def size(self) -> int:
        """How many processes there are, including this one."""
        return self._size

    def Run(
        self, shares: Sequence[Sequence[Job[_Worker, _Result]]]
    ) -> list[list[_Result]]:
        """Returns the results of all jobs, share by share.

        Args:
            shares: the jobs of each process in their order, this one's first.

        Raises:
            Exception: what a job raises, in whichever process.
        """
        sent = []
        for i, jobs in enumerate(shares):
            if i > 0 and jobs and self._Send(i, jobs):
                sent.append(i)
        answers: list[list[_Result] | Exception | None] = [None] * len(shares)
        start = time.monotonic()
        try:
            for i, jobs in enumerate(shares):
                if i not in sent:
                    answers[i] = _run(self._worker, jobs)
        finally:
            patience = 10 * (time.monotonic() - start) + _PATIENCE
            for i in sent:
                answers[i] = self._Receive(i, patience)
        return [
            self._Complete(answer, jobs)
            for answer, jobs in zip(answers, shares, strict=True)
        ]

    def _Send(self, i: int, jobs: Sequence[Job[_Worker, Any]]) -> bool:
        """Returns whether process i works on the jobs now."""
        if not _can_copy():
            return False
        if i not in self._helpers:
            self._helpers[i] = _Helper(self._worker)
        try:
            self._helpers[i].Send(jobs)
        except OSError:
            self._ReportDeath(i)
            return False
        return True

    def _Receive(self, i: int, patience: float) -> list[Any] | Exception | None:
        """Returns results, or what was raised, or None if process i died."""
        try:
            return self._helpers[i].Receive(patience)
        except (EOFError, OSError):
            self._ReportDeath(i)
            return None

    def _ReportDeath(self, i: int) -> None:
        del self._helpers[i]
        logging.getLogger(__name__).warning(
            "A process that shared the work on the particles has died, or was "
            "ended because it didn't answer; what it had to do is done again, "
            "and it is replaced."
        )

    def _Complete(
        self,
        answer: list[_Result] | Exception | None,
        jobs: Sequence[Job[_Worker, _Result]],
    ) -> list[_Result]:
        """Returns the results of a share, whatever came of it elsewhere."""
        if isinstance(answer, Exception):
            raise answer
        if answer is None:
            return _run(self._worker, jobs)
        return answer


class _Helper:
    """A copy of this process, and the line to it."""

    def __init__(self, worker: object) -> None:
        context = multiprocessing.get_context("fork")
        self._line, line = context.Pipe()
        self._num_sent = 0
        process = context.Process(
            target=_serve, args=(worker, line, self._line), daemon=True
        )
        with warnings.catch_warnings():
            # Python warns that a lock which another thread holds now is never
            # released in the copy. The copy runs numpy and the physics only,
            # which take no such lock.
            warnings.simplefilter("ignore", DeprecationWarning)
            process.start()
        line.close()
        self._process = process
        self._may_block = False
        weakref.finalize(self, _dismiss, self._line, process)

    def Send(self, jobs: Sequence[Job[Any, Any]]) -> None:
        """Sends jobs to work on.

        Raises:
            OSError: the copy has died, or doesn't read what is sent.
        """
        self._num_sent += 1
        message = ForkingPickler.dumps((self._num_sent, jobs))
        # The answer to a short message is short, too.
        self._may_block = len(message) > _FITS_INTO_PIPE
        with self._Deadline(_PATIENCE):
            self._line.send_bytes(message)

    def Receive(self, patience: float) -> list[Any] | Exception:
        """Returns the answer to what was sent last.

        After an interrupt there may be an older answer that nobody has
        fetched. It is thrown away.

        Args:
            patience: how long the copy has for it (in seconds).

        Raises:
            EOFError, OSError: the copy has died, or had to be ended.
        """
        while self._line.poll(patience):
            with self._Deadline(patience):
                number, answer = self._line.recv()
            if number == self._num_sent:
                return answer
        self._process.kill()
        raise EOFError("the process doesn't answer")

    def _Deadline(self, seconds: float) -> AbstractContextManager[None]:
        """Returns a deadline for a message that doesn't fit into the pipe."""
        if not self._may_block:
            return contextlib.nullcontext()
        return _deadline(self._process, seconds)


@contextlib.contextmanager
def _deadline(process: ForkProcess, seconds: float) -> Iterator[None]:
    """Kills a process if the block isn't over in time; it may be stopped.

    Whoever waits at the other end of a pipe to it then learns that it is gone.
    """
    timer = threading.Timer(seconds, process.kill)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def _keep_freed_memory() -> None:
    """Lets large arrays of this process and its copies reuse freed memory.

    By default the C library returns the memory of large arrays to the system,
    and getting it back takes longer than calculating with it. Once a block of
    less than 32 MiB was freed, it keeps up to twice as much as that; so one is
    made here and freed at once. A limit that the environment sets
    (MALLOC_TRIM_THRESHOLD_) stays as it is.
    """
    np.empty(_LARGEST_BLOCK, dtype=np.uint8)


def _can_copy() -> bool:
    daemonic = multiprocessing.current_process().daemon
    return sys.platform == "linux" and not daemonic


def _run(
    worker: _Worker, jobs: Sequence[Job[_Worker, _Result]]
) -> list[_Result]:
    return [job.RunOn(worker) for job in jobs]


def _serve(worker: object, line: Connection, others_end: Connection) -> None:
    """Runs the jobs that arrive, until the process that sends them is gone."""
    gc.freeze()  # What was there before isn't this process' to clean up.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    others_end.close()
    with contextlib.suppress(EOFError, OSError):
        for number, jobs in iter(line.recv, None):
            try:
                answer: list[Any] | Exception = _run(worker, jobs)
            except Exception as error:  # It is raised where it was asked for.
                answer = error
            line.send((number, answer))


def _dismiss(line: Connection, process: ForkProcess) -> None:
    with contextlib.suppress(OSError):  # It may have gone already.
        line.send(None)
    line.close()
    process.join(timeout=1.0)
    # One that is stopped doesn't notice anything else.
    process.kill()
