"""Where jobs run: in processes here, or on the workers of a cluster."""

from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
import multiprocessing
import os
import signal
import threading

_CONNECT_SECONDS = 20


@contextmanager
def LocalExecutor(num_processes: int) -> Iterator[Executor]:
    """Runs jobs in processes of this machine, with one thread each.

    Args:
        num_processes: how many.
    """
    # Numpy's own threads would compete with the other processes. It reads
    # these when a process starts.
    for name in "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS":
        os.environ.setdefault(name, "1")
    with ProcessPoolExecutor(
        num_processes,
        mp_context=multiprocessing.get_context("spawn"),
        initializer=_end_with_parent,
    ) as executor:
        yield executor


@contextmanager
def ClusterExecutor(address: str) -> Iterator[Executor]:
    """Runs jobs on the workers of a Dask scheduler that is running.

    Args:
        address: of the scheduler, as tcp://host:8786.

    Raises:
        ValueError: Dask isn't installed, or nothing answers at the address.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise ValueError(
            "--scheduler needs Dask; expected: pip install "
            "'pbpf_drake[cluster]'"
        ) from error
    try:
        client = Client(address, timeout=_CONNECT_SECONDS)
    except (OSError, ValueError) as error:
        raise ValueError(
            f"no scheduler answers at {address!r}: {error}"
        ) from error
    with client, client.get_executor() as executor:
        yield executor


def _end_with_parent() -> None:
    """Lets this process end when the one that started it is killed.

    It also ends, without a message, when both are interrupted by Ctrl-C.
    """
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
