"""Times as whole numbers of ticks, so that their sums are exact.

How long a simulation takes must not depend on when it starts, to the last bit.
"""

import numpy as np
from numpy.typing import ArrayLike

# About a microsecond. The sum of two times is exact, for a hundred years.
TICK = 2.0**-20


def to_ticks(times: ArrayLike) -> np.ndarray:
    """Returns times to the nearest tick (in seconds)."""
    return np.round(np.asarray(times) / TICK) * TICK
