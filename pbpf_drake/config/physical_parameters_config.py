"""How the filter draws friction, mass and dissipation for its particles."""

from dataclasses import dataclass, field

from pbpf_drake.config.distributions import TruncatedGaussian


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
    # Hunt-Crossley dissipation (in s/m). The paper draws a restitution of 0.9
    # ± 0.2 instead, which Drake doesn't have. In the authors' simulator it had
    # no effect, as the table's restitution of 0 cancelled it; so these values
    # are such that nothing bounces.
    dissipation: TruncatedGaussian = field(
        default_factory=lambda: TruncatedGaussian(
            mean=100.0, stddev=30.0, min=10.0
        )
    )

    def ValidateOrThrow(self, name: str) -> None:
        """Raises ValueError, naming the field, if nothing can be drawn."""
        for part in ("friction", "mass", "dissipation"):
            getattr(self, part).ValidateOrThrow(f"{name}.{part}")
