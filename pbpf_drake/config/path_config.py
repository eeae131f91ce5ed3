"""The path on which the robot pushes in a simulated recording."""

from dataclasses import dataclass, field
from itertools import pairwise

from pbpf_drake.config.config_checks import require, require_at_least

_MAX_WAYPOINTS = 10_000
_MAX_TIME = 100_000
# No arm moves its end effector farther (in meters).
_MAX_WAY = 100


@dataclass(kw_only=True)
class Waypoint:
    """Where the end effector is at a time."""

    # From the start of the log (in seconds).
    time: float = 0.0
    # How far it has moved from its start, in the axes of the world (in meters).
    translation: list[float] = field(default_factory=lambda: [0.0] * 3)


@dataclass(kw_only=True)
class PathConfig:
    """The path on which the robot pushes, with its orientation kept."""

    # The frame of the robot's model that follows the path.
    end_effector: str = ""
    # Between two waypoints the path is a smooth curve. The robot starts at its
    # default positions, and is at rest before the first waypoint and after the
    # last one.
    waypoints: list[Waypoint] = field(default_factory=list)
    # Standard deviation of a waypoint's error in x and in y (in meters). It is
    # drawn once per run; a waypoint that repeats the one before it has the same
    # error as that.
    stddev: float = 0.0

    def ValidateOrThrow(self, name: str) -> None:
        """Raises ValueError, naming the field, if there is no such path."""
        require(
            bool(self.end_effector),
            f"{name}.end_effector",
            self.end_effector,
            "the name of a frame of the robot",
        )
        times = [w.time for w in self.waypoints]
        require(
            2 <= len(times) <= _MAX_WAYPOINTS
            and all(b > a for a, b in pairwise(times))
            and max(map(abs, times)) <= _MAX_TIME,
            f"{name}.waypoints",
            times,
            f"from 2 to {_MAX_WAYPOINTS:,}, their times increasing and at most "
            f"{_MAX_TIME:,} s",
        )
        for i, waypoint in enumerate(self.waypoints):
            require(
                len(waypoint.translation) == 3
                and all(abs(x) <= _MAX_WAY for x in waypoint.translation),
                f"{name}.waypoints[{i}].translation",
                waypoint.translation,
                f"three numbers from {-_MAX_WAY} to {_MAX_WAY} m",
            )
        require_at_least(0, self, f"{name}.", ("stddev",), maximum=100)
