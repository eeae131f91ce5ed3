from dataclasses import replace
import math

import pytest

from pbpf_drake.config.adaptive_count_config import AdaptiveCountConfig
from pbpf_drake.config.particle_filter_config import ParticleFilterConfig


@pytest.mark.parametrize(
    "part, bad",
    [
        ("min_particles", 0),
        ("max_divergence", 0.0),
        ("max_divergence", math.nan),
        ("confidence", 0.0),
        ("confidence", 1.0),
        ("confidence", math.nan),
        ("bin_position", 0.0),
        ("bin_position", math.inf),
        ("bin_rotation", -0.1),
    ],
)
def test_a_bad_value_of_the_count_is_named_with_its_field(part, bad):
    count = replace(AdaptiveCountConfig(), **{part: bad})
    config = ParticleFilterConfig(adaptive_count=count)
    expected = rf"^adaptive_count\.{part} is {bad!r}; expected "
    with pytest.raises(ValueError, match=expected):
        config.ValidateOrThrow()


def test_the_count_does_not_adapt_by_default():
    count = ParticleFilterConfig().adaptive_count
    assert not (count.to_belief or count.to_period)
