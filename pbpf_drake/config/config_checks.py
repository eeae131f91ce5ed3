"""Checks of configurations: errors name the field, its value and what fits."""

from collections.abc import Callable
import math
from typing import Any

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform

# Of what is configured, nothing is farther away than this (in meters).
_MAX_DISTANCE = 1e4
# Longer values are cut off in messages.
_MAX_SHOWN = 60
_MAX_MESSAGE = 500


def require(condition: bool, name: str, value: Any, expected: str) -> None:
    """Raises a ValueError unless ``condition`` holds.

    Args:
        condition: whether the value can be used.
        name: of the field, with the fields that it is in: "physics.mass.min".
        value: the field's.
        expected: what would have fit, as in "at least 0".
    """
    if not condition:
        raise ValueError(f"{name} is {_shown(value)}; expected {expected}")


def one_line(error: BaseException) -> str:
    """Returns an error's message in one line, and cut off where it is long."""
    text = " ".join(str(error).split())
    return text if len(text) <= _MAX_MESSAGE else f"{text[:_MAX_MESSAGE]}…"


def require_positive(
    config: Any,
    prefix: str,
    fields: tuple[str, ...],
    *,
    maximum: float = math.inf,
) -> None:
    """Raises a ValueError unless all fields are finite and more than 0.

    Args:
        config: what has the fields.
        prefix: what an error has before the field's name: "detector.".
        fields: their names.
        maximum: the largest value that fits: what is above it can only be a
            mistake.
    """
    expected = f"more than 0{_and_at_most(maximum)}"
    _require_all(
        lambda x: 0 < x <= maximum and x < math.inf,
        config,
        prefix,
        fields,
        expected,
    )


def require_at_least(
    minimum: float,
    config: Any,
    prefix: str,
    fields: tuple[str, ...],
    *,
    maximum: float = math.inf,
) -> None:
    """Raises a ValueError unless all fields are finite and at least a minimum.

    Args:
        minimum: the smallest value that fits.
        config: what has the fields.
        prefix: what an error has before the field's name: "detector.".
        fields: their names.
        maximum: the largest value that fits: what is above it can only be a
            mistake.
    """
    expected = f"at least {minimum}{_and_at_most(maximum)}"
    _require_all(
        lambda x: minimum <= x <= maximum and x < math.inf,
        config,
        prefix,
        fields,
        expected,
    )


def fixed_pose(transform: Transform, name: str) -> RigidTransform:
    """Returns the one pose in the world that a field gives.

    Args:
        transform: the field's value.
        name: of the field.

    Raises:
        ValueError: the pose is random, relative to another frame, not finite,
            or farther away than 10 km.
    """
    base = transform.base_frame
    expected = "none: the pose is in the world"
    require(not base, f"{name}.base_frame", base, expected)
    if not transform.IsDeterministic():
        raise ValueError(f"{name} is random; expected one pose")
    try:
        pose = transform.GetDeterministicValue()
    except RuntimeError as error:
        # Drake refuses a rotation that has NaN in it.
        raise ValueError(
            f"{name} is not finite or has no rotation; expected finite numbers"
        ) from error
    if not np.all(np.isfinite(pose.GetAsMatrix34())):
        raise ValueError(f"{name} is not finite; expected finite numbers")
    require(
        float(np.abs(pose.translation()).max()) <= _MAX_DISTANCE,
        f"{name}.translation",
        pose.translation().tolist(),
        f"numbers from -{_MAX_DISTANCE:g} to {_MAX_DISTANCE:g} m",
    )
    return pose


def _require_all(
    fits: Callable[[Any], bool],
    config: Any,
    prefix: str,
    fields: tuple[str, ...],
    expected: str,
) -> None:
    for field in fields:
        value = getattr(config, field)
        require(fits(value), f"{prefix}{field}", value, expected)


def _and_at_most(maximum: float) -> str:
    return "" if maximum == math.inf else f" and at most {maximum:,}"


def _shown(value: Any) -> str:
    """Returns a value as an error shows it."""
    try:
        text = repr(value)
    except ValueError:  # Python doesn't print an integer of 10,000 digits.
        return "an integer of very many digits"
    return text if len(text) <= _MAX_SHOWN else f"{text[:_MAX_SHOWN]}…"
