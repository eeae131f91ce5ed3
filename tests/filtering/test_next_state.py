import numpy as np
from update_fixtures import NOMINAL, see

from pbpf_drake.filtering.filter_state import MakeInitialState
from pbpf_drake.filtering.next_state import make_next_state
from pbpf_drake.filtering.particle_cloud import ParticleCloud
from pbpf_drake.filtering.particle_history import ParticleHistory
from pbpf_drake.filtering.track_loss import TrackWatch
from pbpf_drake.filtering.update_step import make_update_step
from pbpf_drake.motion.control_path import ControlPath

PATH = ControlPath(np.array([0.0, 0.16]), np.zeros((2, 1)))


def _next(count: int = 3, num_particles: int = 7):
    """The next state of two objects, of which the second is detected."""
    nominal = np.repeat(NOMINAL, 2, axis=0)
    state = MakeInitialState(num_particles, nominal, history_length=2)
    seen = [see(state, [0, 0, 0], 0.25), see(state, [0, 0, 0], 0.75)]
    poses = np.arange(count * 14.0).reshape(count, 2, 7)
    after = make_next_state(
        state,
        step=make_update_step(state, seed=0, path=PATH, detections={1: seen}),
        cloud=ParticleCloud(
            history=ParticleHistory(
                np.array([-0.3, -0.1, 0.0, 0.16]),
                np.stack([poses + 3, poses + 2, poses + 1, poses]),
            ),
            drawn=poses,
            velocities=poses[..., :6],
            failed=np.zeros(count, dtype=bool),
        ),
        weights=np.full(count, 1 / count),
        mean=np.full((2, 7), 9.0),
        watch=TrackWatch(
            disagreement=np.zeros((2, 3)),
            num_rejected=np.array([0.0, 2.0]),
            lost=np.zeros(2, dtype=bool),
        ),
    )
    return state, after, poses


def test_particles_that_were_not_used_repeat_the_others_without_weight():
    _, after, poses = _next()
    np.testing.assert_array_equal(after.poses, poses[[0, 1, 2, 0, 1, 2, 0]])
    np.testing.assert_array_equal(after.weights, [1 / 3] * 3 + [0] * 4)
    assert after.num_used[0] == 3


def test_an_estimate_is_the_mean_from_the_first_detection_on():
    state, after, _ = _next()
    np.testing.assert_array_equal(after.estimates[0, 0], NOMINAL[0])
    np.testing.assert_array_equal(after.estimates[0, 1], np.full(7, 9.0))
    np.testing.assert_array_equal(after.estimates[1], state.estimates[0])
    np.testing.assert_array_equal(after.num_estimates, [0, 1])


def test_detections_are_remembered_by_their_last_stamp():
    _, after, _ = _next()
    np.testing.assert_array_equal(after.detected, [0, 1])
    np.testing.assert_allclose(after.detection_times, [-np.inf, 0.12])


def test_the_state_before_stays_as_it_is():
    state, _, _ = _next()
    expected = MakeInitialState(7, np.repeat(NOMINAL, 2, axis=0), 2)
    for name, value in vars(expected).items():
        np.testing.assert_array_equal(getattr(state, name), value)


def test_the_oldest_poses_make_room_for_those_before_this_update():
    _, after, poses = _next()
    repeated = [0, 1, 2, 0, 1, 2, 0]
    np.testing.assert_array_equal(after.history_times, [-0.1, 0.0])
    np.testing.assert_array_equal(after.history[0], poses[repeated] + 2)
    np.testing.assert_array_equal(after.history[1], poses[repeated] + 1)
