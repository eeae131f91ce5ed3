"""Checks what a motion model returns; it may be a user's own."""

from dataclasses import replace
import functools
import logging

import numpy as np

from pbpf_drake.motion.motion_model import MotionInput, MotionResult


def check_motion(
    result: MotionResult, motion: MotionInput, model: object
) -> MotionResult:
    """Returns a prediction in which what isn't finite counts as failed.

    Args:
        result: what the motion model made of the input.
        motion: the input, whose poses are kept by what failed.
        model: the motion model, for the message.

    Raises:
        ValueError: an array has another shape than MotionResult says.
    """
    shape = motion.poses.shape[:2]
    expected = {
        "poses": (*shape, 7),
        "velocities": (*shape, 6),
        "supports": (*shape, 3),
        "failed": shape[:1],
    }
    for name, expected_shape in expected.items():
        check_shape(getattr(result, name), expected_shape, name, model)
    finite = np.ones(len(result.failed), dtype=bool)
    for array in (result.poses, result.velocities, result.supports):
        finite &= np.isfinite(array).all(axis=(1, 2))
    if finite.all():
        return result
    _SayThatItIsNotFinite(type(model).__name__)
    bad = ~finite[:, None, None]
    return replace(
        result,
        poses=np.where(bad, motion.poses, result.poses),
        velocities=np.where(bad, 0.0, result.velocities),
        supports=np.where(bad, 0.0, result.supports),
        failed=result.failed | ~finite,
    )


@functools.cache
def _SayThatItIsNotFinite(name: str) -> None:
    """Warns once for each motion model."""
    logging.getLogger(__name__).warning(
        "%s returned something that isn't finite; such particles count as "
        "failed",
        name,
    )


def check_shape(
    array: np.ndarray, expected: tuple[int, ...], name: str, model: object
) -> None:
    """Raises ValueError unless an array has the expected shape.

    Args:
        array: what a motion model returned.
        expected: its shape.
        name: what it is.
        model: the motion model.
    """
    if np.shape(array) != expected:
        raise ValueError(
            f"{type(model).__name__} returned {name} of the shape "
            f"{np.shape(array)}; expected {expected}"
        )
