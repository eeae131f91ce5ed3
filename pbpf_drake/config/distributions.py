"""What random numbers are drawn from, as a configuration says it."""

from dataclasses import dataclass

from pbpf_drake.config.config_checks import require, require_at_least

# Larger values can only be a mistake, whatever their unit is ...
_MAX_VALUE = 1_000_000
# ... and so can larger deviations of a position (in meters) and of a rotation
# (in radians).
_MAX_STDDEV = {"position": 100, "rotation": 10}
# Nothing is lighter, slipperier or less dissipative than this (in the SI unit).
_SMALLEST = 1e-6


@dataclass(kw_only=True)
class PoseStddev:
    """Standard deviations of a Gaussian error of a pose."""

    # Of the distance from the true position (in meters).
    position: float = 0.0
    # Of the angle from the true rotation (in radians).
    rotation: float = 0.0

    def ValidateOrThrow(self, name: str, *, minimum: float = 0.0) -> None:
        """Raises ValueError unless both are in range.

        Args:
            name: of the field that has them.
            minimum: the smallest deviation. The largest is 100 m or 10 rad.
        """
        for part, maximum in _MAX_STDDEV.items():
            require_at_least(
                minimum, self, f"{name}.", (part,), maximum=maximum
            )


@dataclass(kw_only=True)
class TruncatedGaussian:
    """A Gaussian whose draws are raised to ``min`` where they fall below."""

    mean: float = 0.0
    stddev: float = 0.0
    min: float = 0.0

    def ValidateOrThrow(self, name: str) -> None:
        """Raises ValueError for a value that no draw can be made from."""
        require(
            -_MAX_VALUE <= self.mean <= _MAX_VALUE,
            f"{name}.mean",
            self.mean,
            f"a number from {-_MAX_VALUE:,} to {_MAX_VALUE:,}",
        )
        for part, minimum in (("stddev", 0), ("min", _SMALLEST)):
            require_at_least(
                minimum, self, f"{name}.", (part,), maximum=_MAX_VALUE
            )


@dataclass(kw_only=True)
class Range:
    """Where a number is drawn from, uniformly unless the field says how."""

    min: float = 0.0
    max: float = 0.0

    def ValidateOrThrow(self, name: str, *, or_zero: bool = False) -> None:
        """Raises ValueError unless 0 < min ≤ max ≤ 1,000,000.

        Args:
            name: of the field that has the range.
            or_zero: whether min may be 0 as well.
        """
        is_positive = self.min > 0 or (or_zero and self.min == 0)
        require(
            is_positive and self.min <= self.max <= _MAX_VALUE,
            name,
            (self.min, self.max),
            f"0 {'<=' if or_zero else '<'} min <= max <= {_MAX_VALUE:,}",
        )
