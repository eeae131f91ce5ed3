"""Configuration of the particle filter; every default is the paper's.

Section numbers refer to "Physics-Based Object 6D-Pose Estimation during
Non-Prehensile Manipulation" (Xu, Papallas, Dogar, ISER 2023). Where the paper
is silent the comment says what was chosen. Values are checked when they are
used, by ``ValidateOrThrow``.
"""

from dataclasses import dataclass, field
import math

from pbpf_drake.config.config_checks import require, require_positive

METHODS = ("pbpf", "pbpf-v", "cvpf", "dope")


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
class PhysicalParametersConfig:
    """The distribution of θ, N(μ_θ, σ_θ²) of Section 4.1."""

    # Coulomb friction coefficient of the object's contacts (Section 6).
    friction: TruncatedGaussian = field(
        default_factory=lambda: TruncatedGaussian(
            mean=0.1, stddev=0.3, min=0.001
        )
    )
    # Mass of the object (in kilograms; Section 6).
    mass: TruncatedGaussian = field(
        default_factory=lambda: TruncatedGaussian(
            mean=0.38, stddev=0.5, min=0.05
        )
    )
    # Hunt-Crossley dissipation (in s/m), the stand-in for the paper's
    # restitution of 0.9 ± 0.2: Drake has none, and in the authors' simulator
    # the table's restitution of 0 cancelled it. These values are dead blows.
    dissipation: TruncatedGaussian = field(
        default_factory=lambda: TruncatedGaussian(
            mean=100.0, stddev=30.0, min=10.0
        )
    )

    def ValidateOrThrow(self, name: str) -> None:
        """Raises ValueError, naming the field, if a distribution is bad."""
        for part in ("friction", "mass", "dissipation"):
            getattr(self, part).ValidateOrThrow(f"{name}.{part}")


@dataclass(kw_only=True)
class VisibilityConfig:
    """The threshold model of PBPF-V for one object (Sections 4.3 and 6).

    The defaults are the paper's for Cheezit and Gelatin; its values for Soup
    are 0.6, 0.45, 0.8, 0.9 and 0.33, in the order of the fields.
    """

    # W_H: importance of a hidden particle where nothing was detected.
    high_weight: float = 0.75
    # W_L: importance of a visible particle where nothing was detected.
    low_weight: float = 0.25
    # V_H: without a detection, a particle less visible than this is hidden.
    high_visibility: float = 0.95
    # V_L: with a detection, a particle less visible than this is penalised.
    low_visibility: float = 0.5
    # α_W: the penalty's factor.
    penalty: float = 0.33

    def ValidateOrThrow(self, name: str) -> None:
        """Raises ValueError unless all are in [0, 1], weights above 0."""
        for part in ("high_visibility", "low_visibility"):
            value = getattr(self, part)
            require(0 <= value <= 1, f"{name}.{part}", value, "in [0, 1]")
        for part in ("high_weight", "low_weight", "penalty"):
            value = getattr(self, part)
            require(0 < value <= 1, f"{name}.{part}", value, "in (0, 1]")


@dataclass(kw_only=True)
class AdaptiveCountConfig:
    """How many of the particles an update has, if not all. Not in the paper."""

    # Whether it is as many as the belief needs; see adaptive_count.
    to_belief: bool = False
    # Whether it is at most as many as fit into the period, by how long the last
    # updates took. Then results depend on the machine and on its load.
    to_period: bool = False
    # The fewest; more where weights are so uneven that these are worth less.
    min_particles: int = 20
    # ε: how far the particles may be from the belief (Kullback-Leibler
    # divergence, in nats) ...
    max_divergence: float = 0.2
    # ... with this probability.
    confidence: float = 0.99
    # Edges of the bins (in meters and radians) over which that is meant: poses
    # in one of them count as the same. A detection can hardly tell them apart.
    bin_position: float = 0.02
    bin_rotation: float = 0.1

    def ValidateOrThrow(self, name: str) -> None:
        """Raises ValueError, naming the field, if a value is out of range."""
        require(
            self.min_particles >= 1,
            f"{name}.min_particles",
            self.min_particles,
            "at least 1",
        )
        require(
            0 < self.confidence < 1,
            f"{name}.confidence",
            self.confidence,
            "in (0, 1)",
        )
        require_positive(
            self, f"{name}.", ("max_divergence", "bin_position", "bin_rotation")
        )


@dataclass(kw_only=True)
class ParticleFilterConfig:
    """Everything that distinguishes one particle filter from another."""

    # M, the number of particles (Section 6; the paper uses 150 for CVPF and
    # for Scene 5).
    num_particles: int = 70
    # Whether an update may have fewer of them.
    adaptive_count: AdaptiveCountConfig = field(
        default_factory=AdaptiveCountConfig
    )
    # Δt, the time between two updates (in seconds; Section 6).
    period: float = 0.16
    # How often within a period the joint positions are sampled, so that what
    # the robot did between two updates counts. Not in the paper.
    control_samples: int = 8
    # The motion model: "physics" (PBPF) or "constant_velocity" (CVPF).
    motion: str = "physics"
    # Whether visibility enters the importance factors (PBPF-V).
    use_visibility: bool = False
    # R, the rays per object (Section 4.3; the number is not in the paper, the
    # authors' code has 39 to 43). With 48 a score was off by up to 0.09.
    num_rays: int = 150
    # ε ~ N(0, σ_f²), added after the prediction (Section 6): of the distance
    # and of the angle in space; what a support prevents of it is left out.
    process_noise: PoseStddev = field(
        default_factory=lambda: PoseStddev(position=0.005, rotation=0.05)
    )
    # σ_DOPE of the observation model (Section 6).
    detection_noise: PoseStddev = field(
        default_factory=lambda: PoseStddev(position=0.02, rotation=0.09)
    )
    # The spread of the first particles around the first detection (Section
    # 6): of the distance in the horizontal plane, as in the authors' code.
    initial_noise: PoseStddev = field(
        default_factory=lambda: PoseStddev(position=0.16, rotation=0.43)
    )
    # The distribution of θ (Section 4.1).
    physics: PhysicalParametersConfig = field(
        default_factory=PhysicalParametersConfig
    )
    # Whether particles are drawn from the detections again where those show
    # that a track is lost; see track_loss. Not in the paper, and only for
    # detectors without a bias: one that is centimetres off all the time looks
    # like a lost track.
    recover_lost_tracks: bool = False
    # A detection older than this when it arrives is not used (in seconds).
    max_detection_age: float = 0.25
    # A particle that is simulated to move faster than this is a failed one
    # (in m/s): nothing that is pushed or tilted does.
    max_speed: float = 2.0
    # The longest step of the physics (in seconds) ...
    time_step: float = 0.04
    # ... and how far things may move or fall within one (in meters).
    max_travel: float = 0.0015
    # All randomness is a pure function of this and of the step.
    seed: int = 0
    # So many processes share the particles: the filter's own, and copies of
    # it that are made at the first update (on Linux; elsewhere it has none).
    # Results do not depend on it.
    parallelism: int = 1

    def ValidateOrThrow(self) -> None:
        """Raises ValueError, naming field, value and what was expected."""
        for part in ("num_particles", "control_samples", "num_rays"):
            value = getattr(self, part)
            require(value >= 1, part, value, "at least 1")
        require_positive(
            self,
            "",
            (
                "period",
                "max_detection_age",
                "max_speed",
                "time_step",
                "max_travel",
            ),
        )
        require(
            self.motion in ("physics", "constant_velocity"),
            "motion",
            self.motion,
            "'physics' or 'constant_velocity'",
        )
        require(self.seed >= 0, "seed", self.seed, "at least 0")
        require(
            self.parallelism >= 1, "parallelism", self.parallelism, "at least 1"
        )
        self.process_noise.ValidateOrThrow("process_noise")
        self.initial_noise.ValidateOrThrow("initial_noise")
        self.detection_noise.ValidateOrThrow("detection_noise", minimum=1e-6)
        self.physics.ValidateOrThrow("physics")
        self.adaptive_count.ValidateOrThrow("adaptive_count")
