"""What random numbers are drawn from, as a configuration says it."""

from dataclasses import dataclass
import math

from pbpf_drake.config.config_checks import require


@dataclass(kw_only=True)
class PoseStddev:
    """Standard deviations of a Gaussian error of a pose."""

    # Of the distance from the true position (in meters).
    position: float = 0.0
    # Of the angle from the true rotation (in radians).
    rotation: float = 0.0

    def ValidateOrThrow(self, name: str, *, minimum: float = 0.0) -> None:
        """Raises ValueError unless both are finite and above ``minimum``."""
        for part in ("position", "rotation"):
            value = getattr(self, part)
            require(
                math.isfinite(value) and value >= minimum,
                f"{name}.{part}",
                value,
                f"a finite number of at least {minimum}",
            )


@dataclass(kw_only=True)
class TruncatedGaussian:
    """A Gaussian whose draws are raised to ``min`` where they fall below."""

    mean: float = 0.0
    stddev: float = 0.0
    min: float = 0.0

    def ValidateOrThrow(self, name: str) -> None:
        """Raises ValueError for a value that no draw can be made from."""
        for part in ("mean", "stddev", "min"):
            value = getattr(self, part)
            require(math.isfinite(value), f"{name}.{part}", value, "finite")
        require(self.stddev >= 0, f"{name}.stddev", self.stddev, "at least 0")
        require(self.min > 0, f"{name}.min", self.min, "more than 0")


@dataclass(kw_only=True)
class Range:
    """Where a number is drawn from, uniformly unless the field says how."""

    min: float = 0.0
    max: float = 0.0

    def ValidateOrThrow(self, name: str, *, or_zero: bool = False) -> None:
        """Raises ValueError unless 0 < min ≤ max < ∞.

        Args:
            name: of the field that has the range.
            or_zero: whether min may be 0 as well.
        """
        is_positive = self.min > 0 or (or_zero and self.min == 0)
        require(
            is_positive and self.min <= self.max < math.inf,
            name,
            (self.min, self.max),
            f"0 {'<=' if or_zero else '<'} min <= max",
        )
