from dataclasses import fields, replace
import math

import pytest

from pbpf_drake.config.visibility_config import VisibilityConfig


def test_defaults_are_the_papers():
    visibility = VisibilityConfig()
    assert (visibility.high_weight, visibility.low_weight) == (0.75, 0.25)
    assert visibility.high_visibility == 0.95
    assert visibility.low_visibility == 0.5
    assert visibility.penalty == 0.33
    visibility.ValidateOrThrow("visibility")


@pytest.mark.parametrize("field", [f.name for f in fields(VisibilityConfig)])
@pytest.mark.parametrize("bad", [-0.1, 1.1, math.nan])
def test_a_bad_threshold_is_named_with_its_field(field, bad):
    config = replace(VisibilityConfig(), **{field: bad})
    with pytest.raises(ValueError, match=rf"^here\.{field} is {bad!r}; exp"):
        config.ValidateOrThrow("here")


@pytest.mark.parametrize("field", ["high_weight", "low_weight", "penalty"])
def test_a_factor_of_zero_would_kill_particles_for_good(field):
    with pytest.raises(ValueError, match=rf"{field} is 0\.0; expected in \(0"):
        replace(VisibilityConfig(), **{field: 0.0}).ValidateOrThrow("here")
