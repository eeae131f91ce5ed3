"""One step of the particle filter, as arrays in and arrays out (Section 4).

The paper's symbols: x_t^[m] is ``poses[m]``, x̄ is ``predicted``, w_t^[m] is
``weights[m]``, x̃_t is ``estimates[0]``, M and K are the first two dimensions
of ``poses``, v is ``visibility``.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pbpf_drake.control_path import ControlPath
from pbpf_drake.motion_model import MotionInput, MotionModel, MotionResult
from pbpf_drake.observation_model import detection_log_likelihood
from pbpf_drake.particle_filter_config import (
    ParticleFilterConfig,
    VisibilityConfig,
)
from pbpf_drake.pose_noise import add_process_noise, sample_initial_poses
from pbpf_drake.pose_statistics import mean_pose
from pbpf_drake.random_streams import MakeGenerator, Stream
from pbpf_drake.resampling import normalize_log_weights, systematic_resample
from pbpf_drake.visibility import VisibilityModel, visibility_log_factor


@dataclass(frozen=True)
class FilterState:
    """All that one update hands to the next.

    Attributes:
        poses: (M, K, 7) particles: qw qx qy qz, x y z (in meters), X_WO.
        velocities: (M, K, 6) angular (rad/s), then translational (m/s).
        weights: (M,) importance factors, normalized.
        estimates: (2, K, 7) the mean of the last update, and of the one
            before it.
        num_estimates: (K,) how many of the two there are; an object without
            any isn't tracked yet.
        detection_times: (K,) stamps of the last detections that were used.
        detected: (K,) 1 where the last update used a detection, else 0.
        step: (1,) count of updates.
    """

    poses: np.ndarray
    velocities: np.ndarray
    weights: np.ndarray
    estimates: np.ndarray
    num_estimates: np.ndarray
    detection_times: np.ndarray
    detected: np.ndarray
    step: np.ndarray


def MakeInitialState(
    num_particles: int, nominal_poses: np.ndarray
) -> FilterState:
    """Returns the state before the first detection.

    Args:
        num_particles: M.
        nominal_poses: (K, 7), which stand for estimates until there are any.
    """
    num_objects = len(nominal_poses)
    return FilterState(
        poses=np.tile(nominal_poses, (num_particles, 1, 1)),
        velocities=np.zeros((num_particles, num_objects, 6)),
        weights=np.full(num_particles, 1.0 / num_particles),
        estimates=np.tile(nominal_poses, (2, 1, 1)),
        num_estimates=np.zeros(num_objects),
        detection_times=np.full(num_objects, -np.inf),
        detected=np.zeros(num_objects),
        step=np.zeros(1),
    )


class ParticleFilterUpdate:
    """The update of PBPF, PBPF-V and CVPF: they differ in their models.

    Args:
        config: the filter's configuration.
        motion_model: p(x_t | x_{t-1}, u_t), without the noise ε.
        visibility_model: makes the filter PBPF-V; None for the others.
        visibility_configs: the thresholds of the K objects.
    """

    def __init__(
        self,
        *,
        config: ParticleFilterConfig,
        motion_model: MotionModel,
        visibility_model: VisibilityModel | None = None,
        visibility_configs: tuple[VisibilityConfig, ...] = (),
    ) -> None:
        self._config = config
        self._motion_model = motion_model
        self._visibility_model = visibility_model
        self._visibility_configs = visibility_configs

    def MakeScratch(self) -> tuple[Any, Any]:
        """Returns work space; nothing in it influences a result."""
        visibility = self._visibility_model
        return (
            self._motion_model.MakeScratch(),
            visibility.MakeScratch() if visibility else None,
        )

    def Update(
        self,
        state: FilterState,
        *,
        path: ControlPath,
        detections: Mapping[int, np.ndarray],
        detection_times: np.ndarray,
        scratch: tuple[Any, Any],
    ) -> FilterState:
        """Returns the next state: resample, predict, observe.

        The paper resamples at the end of an update. Here it is done at the
        beginning of the next, so that the particles and their weights can be
        seen, and the mean is that of the weighted particles. The algorithm
        is the same.

        Args:
            state: the state after the last update.
            path: u_t, what the robot did since then.
            detections: DOPE(z_t), new detections (7,) by object index.
            detection_times: (K,) their stamps; of the others, the old ones.
            scratch: from MakeScratch.
        """
        step = int(state.step[0]) + 1
        state = self._Resample(state, step)
        motion = self._Predict(state, path, step, scratch[0])
        active = state.num_estimates > 0
        predicted = self._AddNoise(motion, active, step)
        velocities = motion.velocities.copy()
        for k in [k for k in detections if not active[k]]:
            predicted[:, k] = self._Start(k, detections[k], step)
            velocities[:, k] = 0.0
        known = active | _mask(detections, len(active))
        predicted = self._motion_model.ResolvePenetration(
            predicted, path.positions[-1], known, scratch[0]
        )
        log_weights = np.where(motion.failed, -np.inf, 0.0)
        for k in np.flatnonzero(active):
            log_weights += self._Observe(predicted[:, k], detections.get(k))
        if self._visibility_model:
            visibility = self._visibility_model.Score(
                particles=predicted,
                active=known,
                robot_positions=path.positions[-1],
                rng=self._Generator(step, Stream.RAY_TARGETS),
                scratch=scratch[1],
            )
            for k in np.flatnonzero(active):
                log_weights += visibility_log_factor(
                    visibility[:, k],
                    detected=k in detections,
                    config=self._visibility_configs[k],
                )
        weights = normalize_log_weights(log_weights)
        mean = mean_pose(predicted, weights)
        last = state.estimates[0]
        return FilterState(
            poses=predicted,
            velocities=velocities,
            weights=weights,
            estimates=np.stack([np.where(known[:, None], mean, last), last]),
            num_estimates=np.minimum(state.num_estimates + known, 2),
            detection_times=detection_times,
            detected=_mask(detections, len(active)) * 1.0,
            step=np.array([float(step)]),
        )

    def _Generator(self, step: int, stream: Stream) -> np.random.Generator:
        return MakeGenerator(seed=self._config.seed, step=step, stream=stream)

    def _Resample(self, state: FilterState, step: int) -> FilterState:
        """X_{t-1} of the paper: survivors, all of the same weight."""
        u = self._Generator(step, Stream.RESAMPLING).random()
        survivors = systematic_resample(state.weights, u)
        return replace(
            state,
            poses=state.poses[survivors],
            velocities=state.velocities[survivors],
        )

    def _Predict(
        self, state: FilterState, path: ControlPath, step: int, scratch: Any
    ) -> MotionResult:
        """f_θ(x_{t-1}, u_t) (Section 4.1)."""
        motion = MotionInput(
            poses=state.poses,
            velocities=state.velocities,
            active=state.num_estimates > 0,
            path=path,
            estimates=state.estimates,
            num_estimates=state.num_estimates,
            step=step,
        )
        return self._motion_model.Propagate(motion, scratch)

    def _AddNoise(
        self, motion: MotionResult, active: np.ndarray, step: int
    ) -> np.ndarray:
        """+ ε, ε ~ N(0, σ_f²), for the objects that are tracked."""
        noisy = add_process_noise(
            motion.poses,
            self._config.process_noise,
            self._Generator(step, Stream.PROCESS_NOISE),
            motion.supports,
        )
        return np.where(active[:, None], noisy, motion.poses)

    def _Start(self, k: int, detection: np.ndarray, step: int) -> np.ndarray:
        """The first particles of an object, around its first detection."""
        rng = self._Generator(step, Stream.INITIAL_PARTICLES)
        # One stream for all objects: each has its own share of it.
        return sample_initial_poses(
            self._config.num_particles,
            detection,
            self._config.initial_noise,
            rng.spawn(k + 1)[k],
        )

    def _Observe(
        self, predicted: np.ndarray, detection: np.ndarray | None
    ) -> np.ndarray | float:
        """log p(z_t | x̄) (Section 4.2); skipped without a detection."""
        if detection is None:
            return 0.0
        return detection_log_likelihood(
            predicted, detection, self._config.detection_noise
        )


def _mask(indices: Iterable[int], length: int) -> np.ndarray:
    """Returns (length,) True at the indices."""
    mask = np.zeros(length, dtype=bool)
    mask[list(indices)] = True
    return mask
