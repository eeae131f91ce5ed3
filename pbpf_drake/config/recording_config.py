"""Configuration of the truth simulation that records a log of a scene.

The filter knows nothing of it: contact model, step, friction, mass and the
detector's errors are the truth's own. Values are checked when they are used, by
``ValidateOrThrow``.
"""

from dataclasses import dataclass, field

from pbpf_drake.config.config_checks import (
    require,
    require_at_least,
)
from pbpf_drake.config.detector_config import DetectorConfig
from pbpf_drake.config.distributions import PoseStddev, Range
from pbpf_drake.config.path_config import PathConfig

# The smallest and the largest value of a field. What is outside can only be a
# mistake: it would take gigabytes, or hours.
_RANGES = {
    "duration": (1e-3, 100_000),
    "time_step": (1e-5, 1),
    "joint_period": (1e-4, 100),
    "ground_truth_period": (1e-4, 100),
    "hydroelastic_modulus": (1, 1e15),
    "mesh_resolution": (0.01, 100),
    "seed": (0, 2**63 - 1),
    "dissipation": (0, 1_000_000),
}
_MAX_GAIN = 1_000_000_000


@dataclass(kw_only=True)
class RecordingConfig:
    """How diagrams/record_scene.py simulates a scene."""

    # Length of the log (in seconds).
    duration: float = 25.0
    # Together with the run's number, this determines all randomness of a run.
    seed: int = 0
    # The fixed step of the simulation (in seconds). All periods are rounded to
    # multiples of it.
    time_step: float = 0.001
    # Time between two joint states in the log, and between two ground truths
    # (in seconds).
    joint_period: float = 0.01
    ground_truth_period: float = 0.02
    # How far from the scene's own pose an object starts, drawn once per run: in
    # x and in y, and by an angle about the vertical through its origin
    # (standard deviations, in meters and in radians).
    start_stddev: PoseStddev = field(
        default_factory=lambda: PoseStddev(position=0.0, rotation=0.0)
    )
    # The true mass of a tracked object over its model's mass.
    mass_scale: Range = field(default_factory=lambda: Range(min=0.85, max=1.2))
    # The true Coulomb friction between objects and everything fixed.
    friction: Range = field(default_factory=lambda: Range(min=0.2, max=0.4))
    # The true Coulomb friction of the robot's surface. Where it touches
    # something with another friction, that of the contact is 2ab/(a + b).
    robot_friction: Range = field(
        default_factory=lambda: Range(min=0.2, max=0.5)
    )
    # Hydroelastic modulus of tracked objects (in pascals). The robot and what
    # is fixed are rigid.
    hydroelastic_modulus: float = 1e7
    # Edge length of a round shape's contact mesh, over the shape's radius.
    mesh_resolution: float = 0.2
    # Hunt-Crossley dissipation of all contact (in s/m).
    dissipation: float = 10.0
    # The joint controller's gains, in the order of the robot's actuators:
    # torque per position error and per velocity error (in N⋅m/rad and
    # N⋅m⋅s/rad), or force (in N/m and N⋅s/m). Gravity is compensated. Joints
    # without an actuator in the robot's file get one after the others.
    stiffness: list[float] = field(default_factory=list)
    damping: list[float] = field(default_factory=list)
    path: PathConfig = field(default_factory=PathConfig)
    detector: DetectorConfig = field(default_factory=DetectorConfig)

    def ValidateOrThrow(self, name: str = "recording") -> None:
        """Raises ValueError, naming field, value and what was expected."""
        for field_name, (low, high) in _RANGES.items():
            require_at_least(low, self, f"{name}.", (field_name,), maximum=high)
        self.start_stddev.ValidateOrThrow(f"{name}.start_stddev")
        for part in ("mass_scale", "friction", "robot_friction"):
            getattr(self, part).ValidateOrThrow(f"{name}.{part}")
        for part in ("stiffness", "damping"):
            values = getattr(self, part)
            require(
                all(0 < x <= _MAX_GAIN for x in values),
                f"{name}.{part}",
                values,
                f"numbers above 0 and up to {_MAX_GAIN:,}",
            )
        self.path.ValidateOrThrow(f"{name}.path")
        self.detector.ValidateOrThrow(f"{name}.detector")
