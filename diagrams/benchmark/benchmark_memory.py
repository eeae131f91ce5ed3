"""How much memory the process holds, and whether that grows."""

from collections.abc import Sequence
import multiprocessing
import os
from pathlib import Path
import resource
import sys

import numpy as np

_ROLLUP = Path("/proc/self/smaps_rollup")


def MemoryInUse() -> int:
    """Returns how much memory this process and its children hold (in bytes).

    What these processes share counts once. Program files don't count: other
    programs share them, too. Outside Linux, it is the most that this process
    has ever held.
    """
    if _ROLLUP.exists():
        children = multiprocessing.active_children()
        return sum(
            _anonymous_memory(pid)
            for pid in (os.getpid(), *(child.pid for child in children))
        )
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most


def _anonymous_memory(pid: int | None) -> int:
    rollup = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii")
    (line,) = (x for x in rollup.splitlines() if x.startswith("Pss_Anon:"))
    return 1024 * int(line.split()[1])


def memory_growth(updates: Sequence[int], memory: Sequence[int]) -> float:
    """Returns the slope of a straight line through the second half.

    Args:
        updates: numbers of updates, at least two.
        memory: in use after them (in bytes).

    Returns:
        In bytes per update.
    """
    half = (len(updates) - 1) // 2
    slope, _ = np.polyfit(updates[half:], memory[half:], 1)
    return float(slope)
