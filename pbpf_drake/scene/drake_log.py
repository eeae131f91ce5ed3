"""Keeps Drake from saying of a model what it has said of it before."""

from collections.abc import Iterator
from contextlib import contextmanager
import logging


class _OnlyNew(logging.Filter):
    """Lets a message pass if it hasn't passed in this process yet."""

    def __init__(self) -> None:
        super().__init__()
        self._said: set[tuple[int, str]] = set()

    def filter(self, record: logging.LogRecord) -> bool:
        said = (record.levelno, record.getMessage())
        is_new = said not in self._said
        self._said.add(said)
        return is_new


_ONLY_NEW = _OnlyNew()


@contextmanager
def EachMessageOnce() -> Iterator[None]:
    """Lets each of Drake's messages pass once.

    The models of a scene are parsed several times, for the filter, for its
    pictures and so on, and each time Drake warns of the same. What Drake says
    at other times isn't touched.
    """
    logger = logging.getLogger("drake")
    logger.addFilter(_ONLY_NEW)
    try:
        yield
    finally:
        logger.removeFilter(_ONLY_NEW)
