"""What other processes are given to do in tests: they import it from here."""

import os
from pathlib import Path
import time


def square(x: int) -> int:
    return x * x


def fail(text: str) -> None:
    raise ValueError(text)


def die() -> None:
    os._exit(7)


def die_once(marker: str) -> str:
    """Ends its process, but not where it is run again."""
    path = Path(marker)
    if not path.exists():
        path.touch()
        os._exit(7)
    return "done"


def wait_for(seconds: float, value: int) -> int:
    time.sleep(seconds)
    return value


def announce_and_wait(folder: str, value: int) -> int:
    """Says in which process it runs, and goes on when a file "go" is there."""
    (Path(folder) / f"{value}-{os.getpid()}").touch()
    end = time.monotonic() + 120
    while not (Path(folder) / "go").exists() and time.monotonic() < end:
        time.sleep(0.02)
    return value


def environment(name: str) -> tuple[int, str]:
    return os.getpid(), os.environ.get(name, "")
