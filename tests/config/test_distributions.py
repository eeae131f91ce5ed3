from dataclasses import replace
import math
import re

import pytest

from pbpf_drake.config.distributions import (
    PoseStddev,
    Range,
    TruncatedGaussian,
)


@pytest.mark.parametrize("part", ["position", "rotation"])
def test_a_deviation_below_the_minimum_is_refused(part):
    stddev = replace(PoseStddev(position=1.0, rotation=1.0), **{part: 0.1})
    stddev.ValidateOrThrow("noise")
    stddev.ValidateOrThrow("noise", minimum=0.1)
    expected = rf"^noise\.{part} is 0.1; expected at least 0.2 and at most 10"
    with pytest.raises(ValueError, match=expected):
        stddev.ValidateOrThrow("noise", minimum=0.2)


@pytest.mark.parametrize(
    "part, bad, expected",
    [
        ("mean", math.inf, "a number from -1,000,000 to 1,000,000"),
        ("stddev", -0.1, "at least 0 and at most 1,000,000"),
        ("stddev", 1e200, "at least 0 and at most 1,000,000"),
        ("min", 0.0, "at least 1e-06 and at most 1,000,000"),
    ],
)
def test_a_gaussian_that_nothing_can_be_drawn_from_is_refused(
    part, bad, expected
):
    good = TruncatedGaussian(mean=-1.0, stddev=0.0, min=0.1)
    good.ValidateOrThrow("mass")
    value = re.escape(repr(bad))
    expected = rf"^mass\.{part} is {value}; expected {expected}$"
    with pytest.raises(ValueError, match=expected):
        replace(good, **{part: bad}).ValidateOrThrow("mass")


@pytest.mark.parametrize(
    "low, high", [(0.2, 0.1), (-0.1, 0.1), (0.1, math.inf), (math.nan, 1.0)]
)
@pytest.mark.parametrize("or_zero", [False, True])
def test_a_range_that_is_none_is_refused(low, high, or_zero):
    with pytest.raises(ValueError, match=r"^mass is \(.*; expected 0 <"):
        Range(min=low, max=high).ValidateOrThrow("mass", or_zero=or_zero)


def test_a_range_begins_at_zero_only_where_that_is_allowed():
    Range(min=0.0, max=0.0).ValidateOrThrow("bias", or_zero=True)
    with pytest.raises(ValueError, match="expected 0 < min <= max"):
        Range(min=0.0, max=0.1).ValidateOrThrow("mass")


@pytest.mark.parametrize("part", ["position", "rotation"])
def test_a_deviation_that_can_only_be_a_mistake_is_refused(part):
    noise = PoseStddev(**{part: 1e200})
    expected = (
        rf"^noise\.{part} is 1e\+200; expected at least 0.0 and at most 10"
    )
    with pytest.raises(ValueError, match=expected):
        noise.ValidateOrThrow("noise")
