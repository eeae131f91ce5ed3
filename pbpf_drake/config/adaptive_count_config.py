"""Whether, and how, the number of particles changes from update to update."""

from dataclasses import dataclass

from pbpf_drake.config.config_checks import (
    require,
    require_at_least,
    require_positive,
)

# A filter has at most so many particles (M).
MAX_PARTICLES = 10_000


@dataclass(kw_only=True)
class AdaptiveCountConfig:
    """How many particles an update has, if not all. Not in the paper."""

    # Whether there are as many as the belief needs; see
    # filtering.adaptive_count.
    to_belief: bool = False
    # Whether there are at most as many as fit into the period, judging by how
    # long the last updates took. Then results depend on the machine and on what
    # else it does.
    to_period: bool = False
    # There are never fewer than this; where weights are so uneven that these
    # are worth less, there are more.
    min_particles: int = 20
    # ε: how much the particles may differ from the belief, as histograms of
    # poses (Kullback-Leibler divergence, in nats) ...
    max_divergence: float = 0.2
    # ... with this probability.
    confidence: float = 0.99
    # Edges of the histograms' bins (in meters and radians). Poses in one bin
    # count as the same; a detection can hardly tell them apart.
    bin_position: float = 0.02
    bin_rotation: float = 0.1

    def ValidateOrThrow(self, name: str) -> None:
        """Raises ValueError, naming the field, if a value is out of range."""
        prefix = f"{name}."
        require_at_least(
            1, self, prefix, ("min_particles",), maximum=MAX_PARTICLES
        )
        fits = 0 < self.confidence < 1
        require(fits, f"{name}.confidence", self.confidence, "in (0, 1)")
        require_positive(self, prefix, ("max_divergence",), maximum=1000)
        bins = ("bin_position", "bin_rotation")
        require_at_least(1e-6, self, prefix, bins, maximum=100)
