"""Randomness as a pure function of (seed, step, stream).

No generator is kept anywhere: each use makes its own, so a context that was
cloned in mid-run continues identically, and no draw depends on who makes it.
"""

from enum import IntEnum

import numpy as np


class Stream(IntEnum):
    """What a generator's numbers are used for."""

    INITIAL_PARTICLES = 0
    PHYSICAL_PARAMETERS = 1
    PARAMETER_ASSIGNMENT = 2
    PROCESS_NOISE = 3
    RAY_TARGETS = 4
    RESAMPLING = 5


def MakeGenerator(
    *, seed: int, step: int, stream: Stream
) -> np.random.Generator:
    """Returns the generator of one purpose at one step.

    Args:
        seed: the filter's seed.
        step: the filter's count of updates.
        stream: the purpose.
    """
    sequence = np.random.SeedSequence(seed, spawn_key=(step, int(stream)))
    return np.random.Generator(np.random.Philox(sequence))
