"""The thresholds and factors by which visibility weighs particles."""

from dataclasses import dataclass

from pbpf_drake.config.config_checks import require


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
        """Raises ValueError unless all are in [0, 1], and no factor is 0."""
        for part in ("high_visibility", "low_visibility"):
            value = getattr(self, part)
            require(0 <= value <= 1, f"{name}.{part}", value, "in [0, 1]")
        for part in ("high_weight", "low_weight", "penalty"):
            value = getattr(self, part)
            require(0 < value <= 1, f"{name}.{part}", value, "in (0, 1]")
