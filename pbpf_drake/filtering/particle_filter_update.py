"""One update of the particle filter, arrays in and arrays out (Section 4).

The paper's symbols: x_t^[m] is ``poses[m]``, x̄ is ``predicted``, w_t^[m] is
``weights[m]``, x̃_t is ``estimates[0]``, M and K are the first two dimensions
of ``poses``, v is ``visibility``. An update may use only the first n of the M
particles; see AdaptiveCountConfig.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.visibility_config import VisibilityConfig
from pbpf_drake.filtering.adaptive_count import count_particles
from pbpf_drake.filtering.filter_state import FilterState, StampedPose
from pbpf_drake.filtering.next_state import make_next_state
from pbpf_drake.filtering.observation_model import weigh_by_detections
from pbpf_drake.filtering.particle_cloud import ParticleCloud
from pbpf_drake.filtering.particle_history import ParticleHistory
from pbpf_drake.filtering.particle_redraw import (
    RedrawnParticles,
    redraw_particles,
)
from pbpf_drake.filtering.pose_noise import add_process_noise
from pbpf_drake.filtering.resampling import (
    normalize_log_weights,
    systematic_resample,
)
from pbpf_drake.filtering.track_loss import watch_tracks
from pbpf_drake.filtering.update_step import UpdateStep, make_update_step
from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.motion.motion_checks import check_motion, check_shape
from pbpf_drake.motion.motion_model import (
    MotionInput,
    MotionModel,
    MotionResult,
    MotionScratch,
)
from pbpf_drake.poses.pose_statistics import mean_pose
from pbpf_drake.process_crew import Crew
from pbpf_drake.random_streams import Stream
from pbpf_drake.visibility.visibility_model import RayCaster, VisibilityModel
from pbpf_drake.visibility.visibility_weights import visibility_log_factor


@dataclass
class UpdateScratch(Generic[MotionScratch]):
    """Work space of the models; nothing in it influences a result.

    Attributes:
        motion: the motion model's.
        visibility: the visibility model's; None where there is no such model.
    """

    motion: MotionScratch
    visibility: Crew[RayCaster] | None


class ParticleFilterUpdate(Generic[MotionScratch]):
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
        motion_model: MotionModel[MotionScratch],
        visibility_model: VisibilityModel | None = None,
        visibility_configs: tuple[VisibilityConfig, ...] = (),
    ) -> None:
        self._config = config
        self._motion_model = motion_model
        self._visibility_model = visibility_model
        self._visibility_configs = visibility_configs

    def MakeScratch(self) -> UpdateScratch[MotionScratch]:
        """Returns work space; nothing in it influences a result."""
        visibility = self._visibility_model
        return UpdateScratch(
            motion=self._motion_model.MakeScratch(),
            visibility=visibility.MakeScratch(self._config.parallelism)
            if visibility
            else None,
        )

    def Update(
        self,
        state: FilterState,
        *,
        path: ControlPath,
        detections: Mapping[int, Sequence[StampedPose]],
        scratch: UpdateScratch[MotionScratch],
        most: int | None = None,
    ) -> FilterState:
        """Returns the next state: resample, predict, weigh, average.

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
        config = self._config
        step = make_update_step(
            state, seed=config.seed, path=path, detections=detections
        )
        survivors = self._Resample(state, step, most)
        motion = self._Predict(survivors, step, scratch)
        predicted = self._AddNoise(motion, step)
        history = self._History(survivors, predicted, step)
        # Not in the paper: where tracks begin or are lost, particles are drawn
        # from the detections, and whatever penetrates something is pushed out.
        watch = watch_tracks(state, history, motion.supports, step, config)
        redrawn = redraw_particles(predicted, watch.lost, step, config)
        cloud = self._PushOut(history, motion, redrawn, step, scratch)
        log_weights = weigh_by_detections(cloud, step, config.detection_noise)
        log_weights += self._WeighByVisibility(cloud, step, scratch)
        weights = normalize_log_weights(log_weights)
        return make_next_state(
            state,
            step=step,
            cloud=cloud,
            weights=weights,
            mean=mean_pose(cloud.history.end, weights),
            watch=watch,
        )

    def _Resample(
        self, state: FilterState, step: UpdateStep, most: int | None
    ) -> FilterState:
        """X_{t-1} of the paper: n survivors, all of the same weight."""
        u = step.MakeGenerator(Stream.RESAMPLING).random()
        count = count_particles(
            state, step, u, most, self._config.adaptive_count
        )
        survivors = systematic_resample(state.weights, u, count)
        return replace(
            state,
            poses=state.poses[survivors],
            velocities=state.velocities[survivors],
            history=state.history[:, survivors],
        )

    def _Predict(
        self,
        survivors: FilterState,
        step: UpdateStep,
        scratch: UpdateScratch[MotionScratch],
    ) -> MotionResult:
        """f_θ(x_{t-1}, u_t) (Section 4.1)."""
        motion = MotionInput(
            poses=survivors.poses,
            velocities=survivors.velocities,
            active=step.active,
            path=step.path,
            estimates=survivors.estimates,
            num_estimates=survivors.num_estimates,
            step=step.number,
        )
        result = self._motion_model.Propagate(motion, scratch.motion)
        return check_motion(result, motion, self._motion_model)

    def _AddNoise(self, motion: MotionResult, step: UpdateStep) -> np.ndarray:
        """+ ε, ε ~ N(0, σ_f²) (Section 4.1), for the tracked objects."""
        noisy = add_process_noise(
            motion.poses,
            self._config.process_noise,
            step.MakeGenerator(Stream.PROCESS_NOISE),
            motion.supports,
        )
        return np.where(step.active[:, None], noisy, motion.poses)

    def _History(
        self, survivors: FilterState, predicted: np.ndarray, step: UpdateStep
    ) -> ParticleHistory:
        """Returns where the predicted particles are, and were before."""
        begin, end = step.path.times[[0, -1]]
        return ParticleHistory(
            times=np.array([*survivors.history_times, begin, end]),
            poses=np.stack([*survivors.history, survivors.poses, predicted]),
        )

    def _PushOut(
        self,
        history: ParticleHistory,
        motion: MotionResult,
        redrawn: RedrawnParticles,
        step: UpdateStep,
        scratch: UpdateScratch[MotionScratch],
    ) -> ParticleCloud:
        """Pushes the particles out of what they penetrate.

        A new particle rests: it is pushed out freely, and has always been
        where it is at the end.
        """
        is_new = redrawn.is_new[..., None]
        end = self._motion_model.ResolvePenetration(
            redrawn.poses,
            np.where(is_new, 0.0, motion.supports),
            step.path.positions[-1],
            step.known,
            scratch.motion,
        )
        check_shape(end, history.end.shape, "poses", self._motion_model)
        lost = ~np.isfinite(end).all(axis=(1, 2))
        end[lost] = redrawn.poses[lost]
        # What is wholly new doesn't depend on the prediction that failed.
        all_new = np.all(redrawn.is_new[:, step.known], axis=1)
        before = np.where(is_new, end, history.poses[:-1])
        return ParticleCloud(
            history=ParticleHistory(
                history.times, np.concatenate([before, end[None]])
            ),
            drawn=redrawn.poses,
            velocities=np.where(is_new, 0.0, motion.velocities),
            failed=(motion.failed & ~all_new) | lost,
        )

    def _WeighByVisibility(
        self,
        cloud: ParticleCloud,
        step: UpdateStep,
        scratch: UpdateScratch[MotionScratch],
    ) -> np.ndarray:
        """The visibility's share of log w (Section 4.3), (n,)."""
        log_weights = np.zeros(len(cloud.drawn))
        if self._visibility_model is None or scratch.visibility is None:
            return log_weights
        visibility = self._visibility_model.Score(
            particles=cloud.history.at_last_images(
                {k: seen[-1].time for k, seen in step.detections.items()}
            ),
            known=step.known,
            robot_positions=step.path.positions[-1],
            rng=step.MakeGenerator(Stream.RAY_TARGETS),
            scratch=scratch.visibility,
        )
        for k in np.flatnonzero(step.active):
            log_weights += visibility_log_factor(
                visibility[:, k],
                detected=k in step.detections,
                config=self._visibility_configs[k],
            )
        return log_weights
