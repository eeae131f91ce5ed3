"""Which turns of an object can't be told from its shape."""

from dataclasses import dataclass, field

import numpy as np

from pbpf_drake.config.config_checks import require, require_at_least
from pbpf_drake.poses.quaternions import from_rotation_vector

# From here on, a prism is as good as a can.
_MAX_ORDER = 1_000


@dataclass(kw_only=True)
class SymmetryConfig:
    """Turns about one axis of an object that leave it as it is.

    Errors that respect symmetry use it; the filter doesn't.
    """

    # The axis, in the object's frame and of any length; empty if there is none.
    axis: list[float] = field(default_factory=list)
    # How many turns about it there are, the full turn included: 2 for half
    # turns. 0 stands for any turn, as of a can.
    order: int = 0

    def ValidateOrThrow(self, name: str) -> None:
        """Raises ValueError, naming the field, if a value can't be used."""
        axis = np.asarray(self.axis, dtype=float)
        longest = np.max(np.abs(axis), initial=0.0)
        is_axis = len(axis) == 3 and 1e-6 <= longest <= 1e6
        require(
            bool(axis.size == 0 or is_axis),
            f"{name}.axis",
            self.axis,
            "three numbers up to 1e6 that are not all 0, or none",
        )
        require_at_least(0, self, f"{name}.", ("order",), maximum=_MAX_ORDER)
        if self.order and not self.axis:
            raise ValueError(
                f"{name}.order is {self.order!r}, but there is no axis; "
                "expected an axis as well"
            )

    def is_continuous(self) -> bool:
        """Tells if any turn about the axis leaves the object as it is."""
        return bool(self.axis) and self.order == 0

    def unit_axis(self) -> np.ndarray:
        """Returns the axis with a length of 1; zeros where there is none."""
        axis = np.asarray(self.axis or [0.0, 0.0, 0.0], dtype=float)
        return axis / max(float(np.linalg.norm(axis)), 1e-300)

    def turns(self, count: int) -> np.ndarray:
        """Returns the turns as quaternions, (S, 4), w, x, y, z.

        Args:
            count: S if any turn is one: as many, evenly spaced, stand for all.
        """
        number = count if self.is_continuous() else max(self.order, 1)
        if not self.axis:
            number = 1
        angles = 2 * np.pi * np.arange(number) / number
        return from_rotation_vector(angles[:, None] * self.unit_axis())
