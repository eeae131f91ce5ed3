"""Checks of configurations: errors name the field, its value and what fits."""

import math
from typing import Any


def require(condition: bool, name: str, value: Any, expected: str) -> None:
    """Raises a ValueError unless ``condition`` holds.

    Args:
        condition: whether the value can be used.
        name: of the field, with the fields that it is in: "physics.mass.min".
        value: the field's.
        expected: what would have fit, as in "at least 0".
    """
    if not condition:
        raise ValueError(f"{name} is {value!r}; expected {expected}")


def require_positive(config: Any, prefix: str, fields: tuple[str, ...]) -> None:
    """Raises a ValueError unless all fields are finite and more than 0.

    Args:
        config: what has the fields.
        prefix: what an error has before the field's name: "detector.".
        fields: their names.
    """
    for field in fields:
        value = getattr(config, field)
        fits = math.isfinite(value) and value > 0
        require(fits, f"{prefix}{field}", value, "more than 0")


def require_at_least(
    minimum: int, config: Any, prefix: str, fields: tuple[str, ...]
) -> None:
    """Raises a ValueError unless all fields are finite and at least a minimum.

    Args:
        minimum: the smallest value that fits.
        config: what has the fields.
        prefix: what an error has before the field's name: "detector.".
        fields: their names.
    """
    for field in fields:
        value = getattr(config, field)
        fits = math.isfinite(value) and value >= minimum
        require(fits, f"{prefix}{field}", value, f"at least {minimum}")
