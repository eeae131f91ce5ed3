"""Meshcat whose web server only this machine can reach."""

from collections.abc import Iterator
from contextlib import contextmanager
import logging
from typing import Any

from pydrake.geometry import Meshcat, MeshcatParams


def MakeLocalMeshcat() -> Meshcat:
    """Returns a Meshcat at an address of this machine only.

    Drake's own default is that all machines of the network can reach it. The
    address is written to Python's log.

    Raises:
        OSError: none of the ports from 7000 to 7999 is free.
    """
    params = MeshcatParams(host="localhost", show_stats_plot=False)
    try:
        return Meshcat(params)
    except RuntimeError as error:
        raise OSError(
            "Meshcat found no free port from 7000 to 7999 on localhost; end "
            f"a program that has one: {error}"
        ) from error


@contextmanager
def ShortLivedMeshcat() -> Iterator[Meshcat]:
    """Gives a Meshcat to draw in, whose server is gone at the end.

    Drake's Meshcat can't do without a server. Nobody has to know the address of
    this one, so it isn't said.

    Raises:
        OSError: see MakeLocalMeshcat.
    """
    with _only_warnings():
        handle = _Handle(MakeLocalMeshcat())
    try:
        yield handle
    finally:
        handle.Close()


class _Handle:
    """Passes all calls on to Meshcat until it is closed.

    A diagram with a Python system in it is never deleted, and would keep a
    Meshcat that it has, and with it the server.
    """

    def __init__(self, meshcat: Meshcat):
        self._meshcat = meshcat

    def __getattr__(self, name: str) -> Any:
        return getattr(self._meshcat, name)

    def Close(self) -> None:
        self._meshcat = None


@contextmanager
def _only_warnings() -> Iterator[None]:
    """Keeps Drake from saying what is no warning."""
    logger = logging.getLogger("drake")

    def is_warning(record: logging.LogRecord) -> bool:
        return record.levelno >= logging.WARNING

    logger.addFilter(is_warning)
    try:
        yield
    finally:
        logger.removeFilter(is_warning)
