"""How much memory the process holds, and whether that grows."""

from collections.abc import Sequence
from pathlib import Path
import resource
import sys

import numpy as np


def MemoryInUse() -> int:
    """Returns how much memory this process holds (in bytes).

    Outside Linux it is the most that it ever held.
    """
    statistics = Path("/proc/self/statm")
    if statistics.exists():
        pages = int(statistics.read_text(encoding="ascii").split()[1])
        return pages * resource.getpagesize()
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return most if sys.platform == "darwin" else 1024 * most


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
