from dataclasses import replace
import math

import pytest

from pbpf_drake.config.distributions import TruncatedGaussian
from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.physical_parameters_config import (
    PhysicalParametersConfig,
)


def test_defaults_are_the_papers():
    physics = ParticleFilterConfig().physics
    assert (physics.friction.mean, physics.friction.stddev) == (0.1, 0.3)
    assert (physics.mass.mean, physics.mass.stddev) == (0.38, 0.5)
    physics.ValidateOrThrow("physics")


@pytest.mark.parametrize("field", ["friction", "mass", "dissipation"])
@pytest.mark.parametrize(
    "part, bad",
    [
        ("mean", math.nan),
        ("mean", math.inf),
        ("stddev", -0.1),
        ("stddev", math.nan),
        ("min", 0.0),
        ("min", -1.0),
        ("min", math.nan),
    ],
)
def test_a_bad_distribution_is_named_with_its_field(field, part, bad):
    gaussian = replace(
        TruncatedGaussian(mean=1.0, stddev=1.0, min=0.1), **{part: bad}
    )
    physics = replace(PhysicalParametersConfig(), **{field: gaussian})
    config = ParticleFilterConfig(physics=physics)
    expected = rf"^physics\.{field}\.{part} is {bad!r}; expected "
    with pytest.raises(ValueError, match=expected):
        config.ValidateOrThrow()
