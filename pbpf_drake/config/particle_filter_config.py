"""Configuration of the particle filter; every default is the paper's.

Section numbers refer to "Physics-Based Object 6D-Pose Estimation during
Non-Prehensile Manipulation" (Xu, Papallas, Dogar, ISER 2023). Where the paper
is silent, the comment says what was chosen. Values are checked when they are
used, by ``ValidateOrThrow``.
"""

from dataclasses import dataclass, field

from pbpf_drake.config.adaptive_count_config import (
    MAX_PARTICLES,
    AdaptiveCountConfig,
)
from pbpf_drake.config.config_checks import (
    require,
    require_at_least,
    require_positive,
)
from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.config.physical_parameters_config import (
    PhysicalParametersConfig,
)

METHODS = ("pbpf", "pbpf-v", "cvpf", "dope")

# More than this can only be a mistake. It would take gigabytes, or hours.
_MAX_COUNTS = {
    "num_particles": MAX_PARTICLES,
    "control_samples": 1_000,
    "num_rays": 10_000,
    "parallelism": 1_024,
}
_MAX_VALUES = {
    "max_detection_age": 3_600,  # In seconds.
    "max_speed": 1_000,  # In m/s.
}
# With a shorter period (in seconds) a run would never end, and with shorter
# steps (in seconds and in meters) an update.
_MIN_PERIOD = 1e-5
_MIN_TIME_STEP = 1e-4
_MIN_TRAVEL = 1e-5
# Rays of all particles to one object.
_MAX_RAYS = 10_000_000
_MAX_SEED = 2**63 - 1


@dataclass(kw_only=True)
class ParticleFilterConfig:
    """Everything that distinguishes one particle filter from another."""

    # M, the number of particles (Section 6; the paper uses 150 for CVPF and
    # for Scene 5).
    num_particles: int = 70
    # Whether an update may have fewer particles than that.
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
    # R, the number of rays per object (Section 4.3). The paper doesn't say it;
    # the authors' code has 39 to 43. With 48, scores were off by up to 0.09.
    num_rays: int = 150
    # ε ~ N(0, σ_f²), added after the prediction (Section 6). The deviations are
    # those of the distance and of the angle in space. What would lift or tilt
    # an object that stands on something is left out.
    process_noise: PoseStddev = field(
        default_factory=lambda: PoseStddev(position=0.005, rotation=0.05)
    )
    # σ_DOPE of the observation model (Section 6).
    detection_noise: PoseStddev = field(
        default_factory=lambda: PoseStddev(position=0.02, rotation=0.09)
    )
    # How the first particles scatter around the first detection (Section 6).
    # The distance is horizontal, as in the authors' code.
    initial_noise: PoseStddev = field(
        default_factory=lambda: PoseStddev(position=0.16, rotation=0.43)
    )
    # The distribution of θ (Section 4.1).
    physics: PhysicalParametersConfig = field(
        default_factory=PhysicalParametersConfig
    )
    # Whether particles are drawn from the detections again where those show
    # that the track is lost; see filtering.track_loss. Not in the paper, and
    # only for detectors without a bias: if detections are centimetres off all
    # the time, every track looks lost.
    recover_lost_tracks: bool = False
    # A detection that is older than this when it arrives is not used (in
    # seconds). So long the filter remembers where its particles were.
    max_detection_age: float = 2.0
    # A particle whose simulation moves faster than this has failed (in m/s):
    # nothing that is pushed or tips over moves so fast.
    max_speed: float = 2.0
    # The longest step of the physics (in seconds). Steps are shorter ...
    time_step: float = 0.04
    # ... where things would move or fall by more than this (in meters) in one.
    max_travel: float = 0.0015
    # Together with the number of the update, this determines all randomness.
    seed: int = 0
    # How many processes share the particles: the filter's own, and copies of it
    # that are made at the first update (on Linux; elsewhere there are none).
    # Results do not depend on it.
    parallelism: int = 1

    def ValidateOrThrow(self) -> None:
        """Raises ValueError, naming field, value and what was expected."""
        for field_name, maximum in _MAX_COUNTS.items():
            require_at_least(1, self, "", (field_name,), maximum=maximum)
        require(
            self.num_particles * self.num_rays <= _MAX_RAYS,
            "num_rays",
            self.num_rays,
            f"at most {_MAX_RAYS // self.num_particles:,} with num_particles "
            f"{self.num_particles:,}",
        )
        require_at_least(0, self, "", ("seed",), maximum=_MAX_SEED)
        for field_name, maximum in _MAX_VALUES.items():
            require_positive(self, "", (field_name,), maximum=maximum)
        require_at_least(_MIN_PERIOD, self, "", ("period",), maximum=3_600)
        require_at_least(_MIN_TIME_STEP, self, "", ("time_step",), maximum=1)
        require_at_least(_MIN_TRAVEL, self, "", ("max_travel",), maximum=1)
        require(
            self.motion in ("physics", "constant_velocity"),
            "motion",
            self.motion,
            "'physics' or 'constant_velocity'",
        )
        self.process_noise.ValidateOrThrow("process_noise")
        self.initial_noise.ValidateOrThrow("initial_noise")
        self.detection_noise.ValidateOrThrow("detection_noise", minimum=1e-6)
        self.physics.ValidateOrThrow("physics")
        self.adaptive_count.ValidateOrThrow("adaptive_count")
