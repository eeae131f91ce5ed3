"""Processes that share the work on the particles of an update.

Threads of Python take turns, but for what Drake does while it has let go of
the interpreter; processes don't. They are copies of this one, so that nothing
needs to be set up in them, and only arrays travel.
"""

from collections.abc import Callable, Mapping, Sequence
import contextlib
import gc
import logging
import multiprocessing
from multiprocessing.connection import Connection
from multiprocessing.context import ForkProcess
import signal
import sys
from typing import Any
import warnings
import weakref

import numpy as np

# In bytes.
_LARGEST_BLOCK = 31 * 2**20

# What a process works on, in its order: the arguments of each call.
Share = Sequence[Mapping[str, Any]]


class Crew:
    """This process and copies of it, made when they are first needed.

    A copy that has died is replaced at the next call, and what it had to do is
    done here. There are copies on Linux only, and not in a daemonic process,
    which can't have any; elsewhere this process does everything.

    Args:
        target: what works, e.g. an object with contexts of its own. A copy's
            is another one from then on.
        size: how many processes there are, with this one.
    """

    def __init__(self, target: Any, size: int) -> None:
        _keep_freed_memory()
        self._target = target
        self._size = size
        self._helpers: dict[int, _Helper] = {}

    @property
    def size(self) -> int:
        """How many processes there are, with this one."""
        return self._size

    def Run(
        self, function: Callable[..., Any], shares: Sequence[Share]
    ) -> list[list[Any]]:
        """Returns function(target, **arguments) for everything in the shares.

        Args:
            function: found by its name in each process, such as a method.
            shares: one for each process, the first for this one.

        Raises:
            Exception: what the function raises, in whichever process.
        """
        asked = set()
        for i, share in enumerate(shares):
            if i > 0 and share and self._Ask(i, function, share):
                asked.add(i)
        answers: list[list[Any] | Exception | None] = [None] * len(shares)
        try:
            for i, share in enumerate(shares):
                if i not in asked:
                    answers[i] = _work(self._target, function, share)
        finally:
            for i in asked:
                answers[i] = self._Answer(i)
        return [
            self._Complete(answer, function, share)
            for answer, share in zip(answers, shares, strict=True)
        ]

    def _Ask(self, i: int, function: Callable[..., Any], share: Share) -> bool:
        """Returns whether a copy works on it now."""
        if not _can_copy():
            return False
        if i not in self._helpers:
            self._helpers[i] = _Helper(self._target)
        try:
            self._helpers[i].Ask(function, share)
        except OSError:
            self._Lose(i)
            return False
        return True

    def _Answer(self, i: int) -> list[Any] | Exception | None:
        """Returns results, or what was raised, or None if nobody answers."""
        try:
            return self._helpers[i].Answer()
        except (EOFError, OSError):
            self._Lose(i)
            return None

    def _Lose(self, i: int) -> None:
        del self._helpers[i]
        logging.getLogger(__name__).warning(
            "A process that shared the work on the particles has died; what "
            "it had to do is done again, and it is replaced."
        )

    def _Complete(
        self,
        answer: list[Any] | Exception | None,
        function: Callable[..., Any],
        share: Share,
    ) -> list[Any]:
        if isinstance(answer, Exception):
            raise answer
        if answer is None:
            return _work(self._target, function, share)
        return answer


class _Helper:
    """A copy of this process, and the line to it."""

    def __init__(self, target: Any) -> None:
        context = multiprocessing.get_context("fork")
        self._line, line = context.Pipe()
        self._num_asked = 0
        process = context.Process(
            target=_serve, args=(target, line, self._line), daemon=True
        )
        with warnings.catch_warnings():
            # Python warns of locks that other threads hold, for nobody to
            # release in the copy. It runs nothing but numpy and the physics.
            warnings.simplefilter("ignore", DeprecationWarning)
            process.start()
        line.close()
        weakref.finalize(self, _dismiss, self._line, process)

    def Ask(self, function: Callable[..., Any], share: Share) -> None:
        """Sends what to work on.

        Raises:
            OSError: there is nobody at the other end.
        """
        self._num_asked += 1
        self._line.send((self._num_asked, function, share))

    def Answer(self) -> list[Any] | Exception:
        """Returns the answer to the last question.

        One that nobody waited for, because of an interrupt, is passed over.

        Raises:
            EOFError, OSError: there is nobody at the other end any more.
        """
        while True:
            number, answer = self._line.recv()
            if number == self._num_asked:
                return answer


def _keep_freed_memory() -> None:
    """Makes arrays of this process, and of its copies, be made of old memory.

    By default the C library returns the memory of large arrays to the system,
    and getting it back takes longer than calculating with it. It keeps twice as
    much as the largest block that was ever freed, if that is less than 32 MiB
    and the environment has no other limit for it (MALLOC_TRIM_THRESHOLD_).
    """
    np.empty(_LARGEST_BLOCK, dtype=np.uint8)


def _can_copy() -> bool:
    daemonic = multiprocessing.current_process().daemon
    return sys.platform == "linux" and not daemonic


def _work(target: Any, function: Callable[..., Any], share: Share) -> list[Any]:
    return [function(target, **arguments) for arguments in share]


def _serve(target: Any, line: Connection, others_end: Connection) -> None:
    """Works until there is nobody any more to work for."""
    gc.freeze()  # What was there before isn't this process' to clean up.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    others_end.close()
    with contextlib.suppress(EOFError, OSError):
        for number, function, share in iter(line.recv, None):
            try:
                answer: list[Any] | Exception = _work(target, function, share)
            except Exception as error:  # It is raised where it was asked for.
                answer = error
            line.send((number, answer))


def _dismiss(line: Connection, process: ForkProcess) -> None:
    with contextlib.suppress(OSError):  # It may have gone already.
        line.send(None)
    line.close()
    process.join(timeout=1.0)
