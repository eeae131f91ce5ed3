"""The M draws of θ, and which particle has which at a step.

It takes longer to write θ into a context than to simulate the particle. So the
draws are made once, and at each step they are dealt out to the particles anew.
"""

import numpy as np

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.motion.physical_parameters import (
    PhysicalParameters,
    SamplePhysicalParameters,
)
from pbpf_drake.random_streams import MakeGenerator, Stream


def DrawParameterBank(
    config: ParticleFilterConfig, num_objects: int
) -> PhysicalParameters:
    """Returns the M draws of θ of a filter, arrays (M, K)."""
    return SamplePhysicalParameters(
        config.physics,
        (config.num_particles, num_objects),
        MakeGenerator(
            seed=config.seed, step=0, stream=Stream.PHYSICAL_PARAMETERS
        ),
    )


def deal_parameters(config: ParticleFilterConfig, step: int) -> np.ndarray:
    """Returns which draw each particle has at a step, (M,)."""
    rng = MakeGenerator(
        seed=config.seed, step=step, stream=Stream.PARAMETER_ASSIGNMENT
    )
    return rng.permutation(config.num_particles)
