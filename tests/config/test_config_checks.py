import math
import re
from types import SimpleNamespace

import pytest

from pbpf_drake.config.config_checks import (
    require,
    require_at_least,
    require_positive,
)


def test_what_fits_is_accepted():
    require(True, "seed", 0, "at least 0")
    require_positive(SimpleNamespace(a=1e-9, b=2), "", ("a", "b"))
    require_at_least(1, SimpleNamespace(a=1, b=1.5), "", ("a", "b"))


def test_the_error_names_field_value_and_what_fits():
    expected = "motion is 'magic'; expected 'physics'"
    with pytest.raises(ValueError, match=f"^{expected}$"):
        require(False, "motion", "magic", "'physics'")


@pytest.mark.parametrize("bad", [0, -0.5, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("prefix", ["", "recording.detector."])
def test_the_first_field_that_is_not_positive_is_named(prefix, bad):
    config = SimpleNamespace(a=1.0, b=bad, c=-1.0)
    expected = re.escape(f"{prefix}b is {bad!r}; expected more than 0")
    with pytest.raises(ValueError, match=f"^{expected}$"):
        require_positive(config, prefix, ("a", "b", "c"))


@pytest.mark.parametrize("bad", [0, 0.99, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("prefix", ["", "recording.detector."])
def test_the_first_field_below_the_minimum_is_named(prefix, bad):
    config = SimpleNamespace(a=1, b=bad, c=-1)
    expected = re.escape(f"{prefix}b is {bad!r}; expected at least 1")
    with pytest.raises(ValueError, match=f"^{expected}$"):
        require_at_least(1, config, prefix, ("a", "b", "c"))
