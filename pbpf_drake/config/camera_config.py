"""The camera of a scene: where it is, and how it maps points to pixels."""

from dataclasses import dataclass, field

from pydrake.common.schema import Transform
from pydrake.math import RigidTransform

from pbpf_drake.config.config_checks import (
    fixed_pose,
    require,
    require_at_least,
    require_positive,
)

# An image has at most so many pixels in a row or a column.
_MAX_SIZE = 10_000
# Focal lengths and the principal point are at most this (in pixels).
_MAX_PIXELS = 1_000_000


@dataclass(kw_only=True)
class CameraConfig:
    """A pinhole camera without distortion, fixed in the world."""

    # The pose in the world of the optical frame C: z points forward, x to the
    # right and y down in the image.
    X_WC: Transform = field(default_factory=Transform)
    # Size of the image (in pixels).
    width: int = 640
    height: int = 480
    # Focal lengths and principal point (in pixels).
    fx: float = 605.904
    fy: float = 604.460
    cx: float = 311.145
    cy: float = 255.473

    def pose(self) -> RigidTransform:
        """Returns X_WC."""
        return self.X_WC.GetDeterministicValue()

    def ValidateOrThrow(self, name: str) -> None:
        """Raises ValueError, naming the field, if there is no such camera."""
        prefix = f"{name}."
        sizes, lengths = ("width", "height"), ("fx", "fy")
        require_positive(self, prefix, sizes, maximum=_MAX_SIZE)
        require_at_least(0.01, self, prefix, lengths, maximum=_MAX_PIXELS)
        for part in ("cx", "cy"):
            value = getattr(self, part)
            fits = -_MAX_PIXELS <= value <= _MAX_PIXELS
            expected = f"a number from {-_MAX_PIXELS:,} to {_MAX_PIXELS:,}"
            require(fits, f"{name}.{part}", value, expected)
        fixed_pose(self.X_WC, f"{name}.X_WC")
