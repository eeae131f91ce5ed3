import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.filtering.filter_state import (
    FilterState,
    MakeInitialState,
    StampedPose,
)
from pbpf_drake.filtering.particle_filter_update import ParticleFilterUpdate
from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.motion.motion_model import (
    ConstantVelocityMotionModel,
    MotionInput,
)
from pbpf_drake.poses import quaternions

PERIOD = 0.16
NUM_PARTICLES = 5
NOMINAL = np.array([[1.0, 0, 0, 0, 0.1, 0.2, 0.3]] * 2)
DP = np.array([0.01, -0.02, 0.003])
DR = np.array([0.1, -0.05, 0.2])


def _pose(step: float) -> np.ndarray:
    """A pose (7,) that moves by DP and turns by DR about itself per step."""
    q = quaternions.multiply(
        quaternions.from_rotation_vector(step * DR), [0.6, 0.0, 0.8, 0.0]
    )
    return np.concatenate([q, [0.5, 0.4, 0.1] + step * DP])


def _motion(num_estimates=(2, 2), active=(True, True)) -> MotionInput:
    rng = np.random.default_rng(4)
    poses = rng.standard_normal((NUM_PARTICLES, 2, 7))
    poses[..., :4] = quaternions.normalize(poses[..., :4])
    return MotionInput(
        poses=poses,
        velocities=rng.standard_normal((NUM_PARTICLES, 2, 6)),
        active=np.array(active),
        path=ControlPath(np.array([0.0, PERIOD]), np.zeros((2, 3))),
        estimates=np.array([[_pose(7), _pose(3)], [_pose(6), _pose(1)]]),
        num_estimates=np.array(num_estimates, dtype=float),
        step=1,
    )


def _propagate(motion):
    return ConstantVelocityMotionModel().Propagate(motion, None)


def test_particles_move_by_the_difference_of_the_last_two_estimates():
    motion = _motion()
    result = _propagate(motion)
    for k, steps in enumerate((1, 2)):
        np.testing.assert_allclose(
            result.poses[:, k, 4:], motion.poses[:, k, 4:] + steps * DP
        )
        for before, after in zip(
            motion.poses[:, k], result.poses[:, k], strict=True
        ):
            q0, q1 = (
                Rotation.from_quat(x[[1, 2, 3, 0]]) for x in (before, after)
            )
            expected = Rotation.from_rotvec(steps * DR) * q0
            assert (expected.inv() * q1).magnitude() < 1e-14


@pytest.mark.parametrize("num_estimates", [(0, 0), (1, 1), (0, 1)])
def test_without_two_estimates_nothing_moves(num_estimates):
    motion = _motion(num_estimates=num_estimates)
    np.testing.assert_allclose(
        _propagate(motion).poses, motion.poses, atol=1e-15
    )


def test_objects_with_two_estimates_move_and_others_do_not():
    motion = _motion(num_estimates=(2, 1))
    result = _propagate(motion)
    np.testing.assert_allclose(
        result.poses[:, 1], motion.poses[:, 1], atol=1e-15
    )
    assert np.all(result.poses[:, 0, 4:] != motion.poses[:, 0, 4:])


def test_what_is_not_tracked_yet_does_not_move():
    motion = _motion(active=(True, False))
    np.testing.assert_allclose(
        _propagate(motion).poses[:, 1], motion.poses[:, 1], atol=1e-15
    )


def test_no_particle_fails_or_stands_on_anything():
    motion = _motion()
    result = _propagate(motion)
    assert not np.any(result.failed)
    assert result.supports.shape == (NUM_PARTICLES, 2, 3)
    assert not np.any(result.supports)
    np.testing.assert_array_equal(result.velocities, motion.velocities)
    np.testing.assert_allclose(
        np.linalg.norm(result.poses[..., :4], axis=-1), 1, atol=1e-15
    )


def test_contact_is_unknown():
    model, poses = ConstantVelocityMotionModel(), _motion().poses
    resolved = model.ResolvePenetration(
        poses,
        np.zeros((*poses.shape[:2], 3)),
        np.zeros(3),
        np.ones(2, dtype=bool),
        model.MakeScratch(),
    )
    np.testing.assert_array_equal(resolved, poses)


def _noise_free_update() -> ParticleFilterUpdate:
    config = ParticleFilterConfig(
        num_particles=NUM_PARTICLES,
        process_noise=PoseStddev(),
        initial_noise=PoseStddev(),
        recover_lost_tracks=False,
    )
    return ParticleFilterUpdate(
        config=config, motion_model=ConstantVelocityMotionModel()
    )


def _step(update, state, step, detections) -> FilterState:
    path = ControlPath(PERIOD * np.array([step - 1, step]), np.zeros((2, 3)))
    return update.Update(
        state,
        path=path,
        detections=detections,
        scratch=update.MakeScratch(),
    )


def _seen(step: int) -> StampedPose:
    return StampedPose(PERIOD * step, _pose(step))


def test_a_target_of_constant_velocity_is_followed_without_detections():
    """The noise-free limit: exact, for as long as nothing is detected."""
    update = _noise_free_update()
    state = MakeInitialState(NUM_PARTICLES, NOMINAL[:1])
    state.poses[:] = _pose(0)
    state.estimates[:, 0] = _pose(0), _pose(-1)
    state.num_estimates[:] = 2
    for step in range(1, 26):
        seen = {0: [_seen(step)]} if step in (4, 5, 17) else {}
        state = _step(update, state, step, seen)
        np.testing.assert_allclose(
            state.estimates[0, 0, 4:], _pose(step)[4:], atol=1e-12
        )
        turn = quaternions.angle_between(
            state.estimates[0, 0, :4], _pose(step)[:4]
        )
        assert turn < 1e-12
        assert state.detected[0] == (step in (4, 5, 17))


def test_the_first_two_updates_of_a_track_know_no_motion():
    update = _noise_free_update()
    state = MakeInitialState(NUM_PARTICLES, NOMINAL[:1])
    state = _step(update, state, 1, {0: [_seen(1)]})
    np.testing.assert_allclose(state.poses[:, 0], [_pose(1)] * NUM_PARTICLES)
    # Far from the nominal pose, but that was no estimate.
    for step in (2, 3):
        state = _step(update, state, step, {})
        np.testing.assert_allclose(
            state.poses[:, 0], [_pose(1)] * NUM_PARTICLES
        )
