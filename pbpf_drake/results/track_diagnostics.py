"""What can be told of a run afterwards, beside its errors.

That is how visible the estimate was, and which θ the particles had that
survived. At each step, θ is dealt out to the particles anew from a bank of M
draws. So all that is known of θ is what the weights of one step say about it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.log_records import JointRecord
from pbpf_drake.motion.parameter_bank import DrawParameterBank, deal_parameters
from pbpf_drake.random_streams import MakeGenerator, Stream
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.visibility.visibility_model import VisibilityModel

# Shares of the weight: a tenth is below the first value that is told of θ, and
# a tenth is above the last.
SHARES = (0.1, 0.5, 0.9)


@dataclass(frozen=True)
class ParameterTrace:
    """One parameter of θ over a run.

    Attributes:
        survivors: (N, K, 3) the values below which the SHARES of the
            particles' weight are; NaN where an object isn't tracked yet.
        drawn: (K, 3) the same for all draws, with equal weights.
    """

    survivors: np.ndarray
    drawn: np.ndarray


@dataclass(frozen=True)
class Diagnostics:
    """What can be told of a run.

    Attributes:
        visibility: (N, K) visible share of the objects, where they are
            estimated to be; NaN where an object isn't tracked yet.
        friction, mass: of the objects; None without physics.
    """

    visibility: np.ndarray
    friction: ParameterTrace | None
    mass: ParameterTrace | None


def MakeDiagnostics(
    *,
    scene: Scene,
    joints: JointRecord,
    record: TrackRecord,
    config: ParticleFilterConfig,
) -> Diagnostics:
    """Computes the diagnostics of a run.

    Args:
        scene: of the run.
        joints: of the log, in the order of the robot's model.
        record: what the run produced.
        config: of its filter.

    Raises:
        ValueError: nothing can be seen in the scene; see VisibilityModel.
    """
    friction = mass = None
    if record.particles.shape[1] and config.motion == "physics":
        bank = DrawParameterBank(config, len(record.object_names))
        friction = _trace(record, config, bank.friction)
        mass = _trace(record, config, bank.mass)
    visibility = _visibility(scene, joints, record)
    return Diagnostics(visibility, friction, mass)


def weighted_quantiles(
    values: np.ndarray, weights: np.ndarray, shares: Sequence[float]
) -> np.ndarray:
    """Returns the values below which some shares of the weight are.

    Args:
        values: (M,).
        weights: (M,) that sum to 1.
        shares: (S,) in [0, 1].

    Returns:
        (S,) for each share, the first value whose weight, together with those
        of all smaller values, makes up the share.
    """
    order = np.argsort(values)
    cumulated = np.cumsum(weights[order])
    # Rounding makes sums of equal weights miss the shares by a little.
    chosen = np.searchsorted(cumulated, np.asarray(shares) - 1e-12)
    return values[order][np.minimum(chosen, len(values) - 1)]


def _trace(
    record: TrackRecord, config: ParticleFilterConfig, bank: np.ndarray
) -> ParameterTrace:
    """Follows one parameter, (M, K) draws, through the run."""
    num_draws, num_objects = bank.shape
    survivors = np.full((len(record.times), num_objects, len(SHARES)), np.nan)
    for i, weights in enumerate(record.weights):
        dealt = bank[deal_parameters(config, i + 1)]
        for k in np.flatnonzero(record.tracked[i]):
            survivors[i, k] = weighted_quantiles(dealt[:, k], weights, SHARES)
    even = np.full(num_draws, 1 / num_draws)
    drawn = [weighted_quantiles(bank[:, k], even, SHARES)
             for k in range(num_objects)]  # fmt: skip
    return ParameterTrace(survivors, np.array(drawn))


def _visibility(
    scene: Scene, joints: JointRecord, record: TrackRecord
) -> np.ndarray:
    """Scores the estimates as if they were particles, (N, K)."""
    model = VisibilityModel(scene=scene, num_rays=scene.filter.num_rays)
    scratch = model.MakeScratch()
    visibility = np.full(record.tracked.shape, np.nan)
    for i, time in enumerate(record.times):
        q = [np.interp(time, joints.times, x) for x in joints.positions.T]
        tracked = record.tracked[i]
        if not tracked.any():
            continue
        scores = model.Score(
            particles=record.poses[i, None],
            known=tracked,
            robot_positions=np.array(q),
            rng=MakeGenerator(
                seed=record.seed, step=i + 1, stream=Stream.RAY_TARGETS
            ),
            scratch=scratch,
        )
        visibility[i, tracked] = scores[0, tracked]
    return visibility
