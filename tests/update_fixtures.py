"""Updates of the filter by hand, without contact or a Drake system."""

from collections.abc import Mapping, Sequence

from filter_fixtures import PERIOD
import numpy as np

from pbpf_drake.control_path import ControlPath
from pbpf_drake.filter_state import FilterState, MakeInitialState, StampedPose
from pbpf_drake.motion_model import MotionInput, MotionModel, MotionResult
from pbpf_drake.particle_filter_config import ParticleFilterConfig, PoseStddev
from pbpf_drake.particle_filter_update import ParticleFilterUpdate

VELOCITY = np.array([0.05, -0.1, 0.02])
UNIT = np.array([1.0, 0.0, 0.0, 0.0])
NOMINAL = np.array([[1.0, 0, 0, 0, 0.1, 0.2, 0.3]])


class FreeMotion:
    """Everything moves with one known velocity, through everything."""

    def __init__(self, velocity=VELOCITY, fails=()):
        self.velocity = np.asarray(velocity)
        self.fails = list(fails)

    def MakeScratch(self):
        return None

    def Propagate(self, motion: MotionInput, scratch) -> MotionResult:
        poses = motion.poses.copy()
        duration = motion.path.times[-1] - motion.path.times[0]
        poses[:, motion.active, 4:] += self.velocity * duration
        failed = np.zeros(len(poses), dtype=bool)
        failed[self.fails] = True
        poses[failed] = motion.poses[failed]
        supports = np.zeros((*poses.shape[:2], 3))
        return MotionResult(poses, motion.velocities, supports, failed)

    def ResolvePenetration(
        self, poses, supports, robot_positions, active, scratch
    ):
        return poses


def make_config(**changes) -> ParticleFilterConfig:
    """Returns a config of Gaussians that aren't turned, and changes."""
    defaults = {
        "num_particles": 200,
        "process_noise": PoseStddev(position=0.01),
        "detection_noise": PoseStddev(position=0.02, rotation=0.09),
        "initial_noise": PoseStddev(position=0.16),
    }
    return ParticleFilterConfig(**{**defaults, **changes})


def make_update(
    motion_model: MotionModel | None = None, **changes
) -> ParticleFilterUpdate:
    """Returns an update with free motion, and changes of its config."""
    return ParticleFilterUpdate(
        config=make_config(**changes), motion_model=motion_model or FreeMotion()
    )


def step(
    update: ParticleFilterUpdate,
    state: FilterState,
    seen: Mapping[int, Sequence[StampedPose]] | None = None,
    most: int | None = None,
) -> FilterState:
    """One update of a period, with detections of objects by index."""
    end = PERIOD * (state.step[0] + 1)
    return update.Update(
        state,
        path=ControlPath(np.array([end - PERIOD, end]), np.zeros((2, 1))),
        detections=seen or {},
        scratch=update.MakeScratch(),
        most=most,
    )


def see(
    state: FilterState,
    p: Sequence[float],
    fraction: float = 1.0,
    q: np.ndarray = UNIT,
) -> StampedPose:
    """A detection in the next period."""
    time = PERIOD * (state.step[0] + fraction)
    return StampedPose(time, np.concatenate([q, p]))


def make_cloud(
    mean: np.ndarray, covariance: np.ndarray, count: int
) -> FilterState:
    """A track of one object that isn't turned."""
    rng = np.random.default_rng(6)
    state = MakeInitialState(count, NOMINAL)
    p = rng.multivariate_normal(mean, covariance, count)
    state.poses[:, 0] = np.concatenate([np.tile(UNIT, (count, 1)), p], axis=1)
    state.estimates[:, 0] = np.concatenate([UNIT, mean])
    state.num_estimates[:] = 1
    return state


def moments(state: FilterState) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of the first object's weighted positions."""
    p = state.poses[:, 0, 4:]
    mean = state.weights @ p
    return mean, np.einsum("m,mi,mj->ij", state.weights, p - mean, p - mean)
