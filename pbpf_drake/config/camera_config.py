"""The camera of a scene: where it is, and how it maps points to pixels."""

from dataclasses import dataclass, field
import math

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform

from pbpf_drake.config.config_checks import require, require_positive


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
        for field_name in ("cx", "cy", "width", "height", "fx", "fy"):
            value = getattr(self, field_name)
            fits = math.isfinite(value)
            require(fits, f"{name}.{field_name}", value, "a number")
        require_positive(self, f"{name}.", ("width", "height", "fx", "fy"))
        require(
            not self.X_WC.base_frame,
            f"{name}.X_WC.base_frame",
            self.X_WC.base_frame,
            "none: the pose is in the world",
        )
        if not self.X_WC.IsDeterministic():
            raise ValueError(f"{name}.X_WC is random; expected one pose")
        if not np.all(np.isfinite(self.pose().GetAsMatrix4())):
            raise ValueError(f"{name}.X_WC is not finite")
