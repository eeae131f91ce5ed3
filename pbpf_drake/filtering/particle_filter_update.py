"""One step of the particle filter, as arrays in and arrays out (Section 4).

The paper's symbols: x_t^[m] is ``poses[m]``, x̄ is ``predicted``, w_t^[m] is
``weights[m]``, x̃_t is ``estimates[0]``, M and K are the first two dimensions
of ``poses``, v is ``visibility``. Within an update there may be fewer than M
particles; see AdaptiveCountConfig.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.visibility_config import VisibilityConfig
from pbpf_drake.filtering.adaptive_count import bin_labels, needed_particles
from pbpf_drake.filtering.filter_state import FilterState, StampedPose
from pbpf_drake.filtering.observation_model import (
    detection_log_likelihood,
    poses_at,
)
from pbpf_drake.filtering.pose_noise import add_process_noise, sample_around
from pbpf_drake.filtering.resampling import (
    effective_sample_size,
    normalize_log_weights,
    systematic_resample,
)
from pbpf_drake.filtering.track_loss import is_lost, mean_disagreement
from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.motion.motion_model import (
    MotionInput,
    MotionModel,
    MotionResult,
)
from pbpf_drake.poses.pose_statistics import mean_pose
from pbpf_drake.random_streams import MakeGenerator, Stream
from pbpf_drake.visibility.visibility_model import (
    VisibilityModel,
    visibility_log_factor,
)

# First particles are chosen from this many times as many: of 70 that are
# spread over 0.16 m and 0.43 rad, about one would be where the object is.
_CANDIDATES = 100


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
            visibility.MakeScratch(self._config.parallelism)
            if visibility
            else None,
        )

    def Update(
        self,
        state: FilterState,
        *,
        path: ControlPath,
        detections: Mapping[int, Sequence[StampedPose]],
        scratch: tuple[Any, Any],
        most: int | None = None,
    ) -> FilterState:
        """Returns the next state: resample, predict, observe.

        The paper resamples at the end of an update. Here it is done at the
        beginning of the next, so that the particles and their weights can be
        seen, and the mean is that of the weighted particles. The algorithm
        is the same.

        Args:
            state: the state after the last update.
            path: u_t, what the robot did since then.
            detections: DOPE(z_t): by object index, the detections that no
                update has used yet, the latest last; no empty ones.
            scratch: from MakeScratch.
            most: the update has at most so many particles, if that isn't
                below the configured minimum; by default M.
        """
        step = int(state.step[0]) + 1
        state = self._Resample(state, detections, step, most)
        active = state.num_estimates > 0
        known = active | _mask(detections, len(active))
        motion = self._Predict(state, path, step, scratch[0])
        predicted = self._AddNoise(motion, active, step)
        state = self._Compare(state, predicted, motion.supports, detections)
        drawn, started = self._Start(state, predicted, detections, step)
        resolved = self._motion_model.ResolvePenetration(
            drawn,
            np.where(started[..., None], 0.0, motion.supports),
            path.positions[-1],
            known,
            scratch[0],
        )
        before = np.where(started[..., None], resolved, state.poses)
        # What is drawn anew doesn't depend on the prediction.
        failed = motion.failed & ~np.all(started[:, known], axis=1)
        log_weights = np.where(failed, -np.inf, 0.0)
        for k, seen in detections.items():
            log_weights += self._Observe(
                before[:, k], resolved[:, k], path, seen
            )
            if not active[k]:  # These detections have chosen the particles.
                log_weights -= self._Observe(
                    drawn[:, k], drawn[:, k], path, seen
                )
        if self._visibility_model:
            imaged = _at_images(before, resolved, path, detections)
            log_weights += self._SeeParticles(
                imaged, path, detections, (active, known), step, scratch[1]
            )
        velocities = np.where(started[..., None], 0.0, motion.velocities)
        return self._MakeState(
            state, resolved, velocities, log_weights, known, detections
        )

    def _Generator(self, step: int, stream: Stream) -> np.random.Generator:
        return MakeGenerator(seed=self._config.seed, step=step, stream=stream)

    def _Resample(
        self,
        state: FilterState,
        detections: Mapping[int, Sequence[StampedPose]],
        step: int,
        most: int | None,
    ) -> FilterState:
        """X_{t-1} of the paper: n survivors, all of the same weight."""
        u = self._Generator(step, Stream.RESAMPLING).random()
        count = self._Count(state, detections, u, most)
        survivors = systematic_resample(state.weights, u, count)
        return replace(
            state,
            poses=state.poses[survivors],
            velocities=state.velocities[survivors],
        )

    def _Count(
        self,
        state: FilterState,
        detections: Mapping[int, Sequence[StampedPose]],
        u: float,
        most: int | None,
    ) -> int:
        """Returns n, how many particles this update has.

        All of them where a track begins: what is believed then isn't in the
        particles yet.
        """
        config, count = self._config.adaptive_count, len(state.weights)
        if most is not None:
            count = min(count, max(most, config.min_particles))
        active = state.num_estimates > 0
        if not config.to_belief or not active[list(detections)].all():
            return count
        labels = bin_labels(
            state.poses[:, active],
            state.estimates[0, active],
            (config.bin_position, config.bin_rotation),
        )
        size = effective_sample_size(state.weights)
        return needed_particles(
            labels,
            state.weights,
            u,
            efficiency=min(size / state.num_used[0], 1.0),
            most=count,
            config=config,
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

    def _Compare(
        self,
        state: FilterState,
        predicted: np.ndarray,
        supports: np.ndarray,
        detections: Mapping[int, Sequence[StampedPose]],
    ) -> FilterState:
        """Keeps track of how detections and particles disagree."""
        disagreement = state.disagreement.copy()
        for k, seen in detections.items():
            if state.num_estimates[k] > 0:
                disagreement[k] = mean_disagreement(
                    disagreement[k],
                    predicted[:, k, 4:],
                    np.array([detection.pose[4:] for detection in seen]),
                    self._config.detection_noise.position,
                    _common_support(supports[:, k]),
                )
        return replace(state, disagreement=disagreement)

    def _Start(
        self,
        state: FilterState,
        predicted: np.ndarray,
        detections: Mapping[int, Sequence[StampedPose]],
        step: int,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Draws particles from detections, where a track begins or is lost.

        Of an object that is lost, every other particle is drawn anew; the
        observation then decides between the two halves.

        Returns:
            The particles (M, K, 7), and which of them are new, (M, K).
        """
        predicted = predicted.copy()
        new = np.zeros(predicted.shape[:2], dtype=bool)
        for k, seen in detections.items():
            if state.num_estimates[k] == 0:
                new[:, k] = True
            elif self._config.recover_lost_tracks and is_lost(
                state.disagreement[k]
            ):
                new[::2, k] = True
                state.disagreement[k] = 0.0
            count = int(np.count_nonzero(new[:, k]))
            if count:
                predicted[new[:, k], k] = self._Draw(k, seen, count, step)
        return predicted, new

    def _Draw(
        self, k: int, seen: Sequence[StampedPose], count: int, step: int
    ) -> np.ndarray:
        """Particles of one object from its detections, (count, 7).

        Candidates are drawn around the last detection with the initial
        spread, and chosen by the likelihood of all that there are.
        """
        # One stream for all objects: each has its own share of it.
        rng = self._Generator(step, Stream.INITIAL_PARTICLES).spawn(k + 1)[k]
        candidates = sample_around(
            seen[-1].pose,
            _CANDIDATES * count,
            self._config.initial_noise,
            rng,
        )
        log_weights = [
            detection_log_likelihood(
                candidates, detection.pose, self._config.detection_noise
            )
            for detection in seen
        ]
        weights = normalize_log_weights(np.sum(log_weights, axis=0))
        return rng.choice(candidates, count, p=weights)

    def _Observe(
        self,
        start: np.ndarray,
        end: np.ndarray,
        path: ControlPath,
        seen: Sequence[StampedPose],
    ) -> np.ndarray:
        """log p(z_t | x̄) (Section 4.2), (M,), at the times of the images."""
        log_likelihood = np.zeros(len(end))
        for detection in seen:
            log_likelihood += detection_log_likelihood(
                poses_at(start, end, _fraction(path, detection.time)),
                detection.pose,
                self._config.detection_noise,
            )
        return log_likelihood

    def _SeeParticles(
        self,
        predicted: np.ndarray,
        path: ControlPath,
        detections: Mapping[int, Sequence[StampedPose]],
        masks: tuple[np.ndarray, np.ndarray],
        step: int,
        scratch: Any,
    ) -> np.ndarray:
        """The visibility's share of log w (Section 4.3), (M,)."""
        assert self._visibility_model is not None
        active, known = masks
        visibility = self._visibility_model.Score(
            particles=predicted,
            active=known,
            robot_positions=path.positions[-1],
            rng=self._Generator(step, Stream.RAY_TARGETS),
            scratch=scratch,
        )
        log_weights = np.zeros(len(predicted))
        for k in np.flatnonzero(active):
            log_weights += visibility_log_factor(
                visibility[:, k],
                detected=k in detections,
                config=self._visibility_configs[k],
            )
        return log_weights

    def _MakeState(
        self,
        state: FilterState,
        predicted: np.ndarray,
        velocities: np.ndarray,
        log_weights: np.ndarray,
        known: np.ndarray,
        detections: Mapping[int, Sequence[StampedPose]],
    ) -> FilterState:
        """The next state, with the mean of the weighted particles.

        Particles that aren't used have a place in it all the same: they repeat
        the others.
        """
        weights = normalize_log_weights(log_weights)
        mean, last = mean_pose(predicted, weights), state.estimates[0]
        spare = np.zeros(len(state.weights) - len(weights))
        times = state.detection_times.copy()
        for k, used in detections.items():
            times[k] = used[-1].time
        return FilterState(
            poses=_repeat(predicted, len(spare)),
            velocities=_repeat(velocities, len(spare)),
            weights=np.concatenate([weights, spare]),
            num_used=np.array([float(len(weights))]),
            estimates=np.stack([np.where(known[:, None], mean, last), last]),
            num_estimates=np.minimum(state.num_estimates + known, 2),
            detection_times=times,
            detected=_mask(detections, len(known)) * 1.0,
            disagreement=state.disagreement,
            step=state.step + 1,
        )


def _fraction(path: ControlPath, time: float) -> float:
    """Returns how much of the path had passed at a time."""
    duration = max(path.times[-1] - path.times[0], 1e-9)
    return (time - path.times[0]) / duration


def _at_images(
    start: np.ndarray,
    end: np.ndarray,
    path: ControlPath,
    detections: Mapping[int, Sequence[StampedPose]],
) -> np.ndarray:
    """Returns the particles when they were last imaged, (M, K, 7).

    Objects that weren't detected are where they are at the end.
    """
    imaged = end.copy()
    for k, seen in detections.items():
        fraction = _fraction(path, seen[-1].time)
        imaged[:, k] = poses_at(start[:, k], end[:, k], fraction)
    return imaged


def _common_support(supports: np.ndarray) -> np.ndarray:
    """Returns the unit normal (3,) that most particles stand on, or zeros."""
    mean = np.mean(supports, axis=0)
    length = np.linalg.norm(mean)
    return mean / length if length > 0.5 else np.zeros(3)


def _repeat(particles: np.ndarray, num_spare: int) -> np.ndarray:
    """Returns (n, ...) followed by so many repetitions of its rows."""
    count = len(particles)
    return particles[np.arange(count + num_spare) % count]


def _mask(indices: Iterable[int], length: int) -> np.ndarray:
    """Returns (length,) True at the indices."""
    mask = np.zeros(length, dtype=bool)
    mask[list(indices)] = True
    return mask
