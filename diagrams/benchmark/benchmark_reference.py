"""How far predicted poses are from those of a fine-step simulation.

A sample is the input of one timed update, with one θ for all its objects. The
reference is the filter's own motion model with a step of 0.2 ms. All engines
predict the same samples: same poses, velocities, controls and θ. The samples'
θ are spread evenly over the filter's distribution.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from pbpf_drake.config.distributions import TruncatedGaussian
from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.physical_parameters_config import (
    PhysicalParametersConfig,
)
from pbpf_drake.motion.motion_model import MotionInput, MotionResult
from pbpf_drake.motion.physical_parameters import PhysicalParameters
from pbpf_drake.motion.physics_motion_model import PhysicsMotionModel
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.prediction_model import PredictionModel

_FINE_STEP = 2e-4
# So many particles of an update are compared; more would tell little more.
_MAX_PARTICLES = 70
# An object that moves by more than this in an update is pushed (in meters).
_PUSHED = 5e-4


@dataclass(frozen=True)
class Sample:
    """A prediction that every engine makes.

    Attributes:
        update: which of the timed updates it is.
        motion: the update's input, with its first particles only.
        parameters: one θ for all objects and particles, of single numbers.
    """

    update: int
    motion: MotionInput
    parameters: PhysicalParameters


@dataclass(frozen=True)
class PredictionErrors:
    """How far off predictions are, over samples, particles and objects.

    Attributes:
        position: (n,) (in meters).
        rotation: (n,) (in radians).
    """

    position: np.ndarray
    rotation: np.ndarray


def make_samples(
    motions: Sequence[MotionInput],
    config: PhysicalParametersConfig,
    count: int,
) -> list[Sample]:
    """Returns samples that are evenly spread over updates and θ.

    Args:
        motions: the inputs of all timed updates.
        config: the distribution of θ.
        count: how many; at most one of each update.
    """
    count = min(count, len(motions))
    # Always the same seed, so that the samples are the same in every run.
    rng = np.random.default_rng(0)
    friction, mass, dissipation = (
        rng.permutation(_even_draws(gaussian, count))
        for gaussian in (config.friction, config.mass, config.dissipation)
    )
    updates = (np.arange(count) + 0.5) * len(motions) / count
    return [
        Sample(
            update=int(update),
            motion=_shorten(motions[int(update)]),
            parameters=PhysicalParameters(friction[i], mass[i], dissipation[i]),
        )
        for i, update in enumerate(updates)
    ]


def _even_draws(gaussian: TruncatedGaussian, count: int) -> np.ndarray:
    """Returns the middles of equal shares of probability, (count,)."""
    quantiles = norm.ppf((np.arange(count) + 0.5) / count)
    draws = gaussian.mean + gaussian.stddev * quantiles
    return np.maximum(draws, gaussian.min)


def _shorten(motion: MotionInput) -> MotionInput:
    return replace(
        motion,
        poses=motion.poses[:_MAX_PARTICLES],
        velocities=motion.velocities[:_MAX_PARTICLES],
    )


def PredictReference(
    *,
    model: PredictionModel,
    config: ParticleFilterConfig,
    samples: Sequence[Sample],
) -> Iterator[MotionResult]:
    """Yields the prediction of each sample with a fine step."""
    yield from PredictSamples(
        model=model,
        config=replace(config, time_step=_FINE_STEP),
        samples=samples,
    )


def PredictSamples(
    *,
    model: PredictionModel,
    config: ParticleFilterConfig,
    samples: Sequence[Sample],
) -> Iterator[MotionResult]:
    """Yields the prediction of each sample, as the filter would make it."""
    for sample in samples:
        own = replace(
            config,
            num_particles=len(sample.motion.poses),
            physics=_always(sample.parameters),
        )
        motion_model = PhysicsMotionModel(model=model, config=own)
        yield motion_model.Propagate(sample.motion, motion_model.MakeScratch())


def _always(parameters: PhysicalParameters) -> PhysicalParametersConfig:
    """Returns a distribution whose draws are all these parameters."""

    def fix(value: np.ndarray) -> TruncatedGaussian:
        return TruncatedGaussian(mean=float(value), stddev=0.0, min=1e-9)

    return PhysicalParametersConfig(
        friction=fix(parameters.friction),
        mass=fix(parameters.mass),
        dissipation=fix(parameters.dissipation),
    )


def compare_predictions(
    poses: Sequence[np.ndarray], references: Sequence[MotionResult]
) -> PredictionErrors:
    """Returns the errors of an engine.

    Args:
        poses: (M, K, 7) its predictions of the samples.
        references: of the same samples. Particles that failed are left out.
    """
    ok = [~reference.failed for reference in references]
    dut = np.concatenate([p[k] for p, k in zip(poses, ok, strict=True)])
    ref = np.concatenate(
        [r.poses[k] for r, k in zip(references, ok, strict=True)]
    )
    distance = np.linalg.norm(dut[..., 4:] - ref[..., 4:], axis=-1)
    angle = quaternions.angle_between(dut[..., :4], ref[..., :4])
    return PredictionErrors(distance.ravel(), angle.ravel())


def pushed_share(
    samples: Sequence[Sample], references: Sequence[MotionResult]
) -> float:
    """Returns which share of all objects the robot moves, in [0, 1]."""
    moved = [
        np.linalg.norm(r.poses[..., 4:] - s.motion.poses[..., 4:], axis=-1)
        for s, r in zip(samples, references, strict=True)
    ]
    return float(np.mean(np.concatenate(moved) > _PUSHED))
