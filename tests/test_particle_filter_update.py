from dataclasses import fields, replace

from filter_fixtures import PERIOD, write_blocks_scene
import numpy as np
import pytest

from pbpf_drake import quaternions
from pbpf_drake.control_path import ControlPath
from pbpf_drake.motion_model import MotionInput, MotionResult
from pbpf_drake.particle_filter_config import (
    ParticleFilterConfig,
    PoseStddev,
    VisibilityConfig,
)
from pbpf_drake.particle_filter_update import (
    FilterState,
    MakeInitialState,
    ParticleFilterUpdate,
    StampedPose,
)
from pbpf_drake.visibility import VisibilityModel

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

    def ResolvePenetration(self, poses, robot_positions, active, scratch):
        return poses


def _config(**changes) -> ParticleFilterConfig:
    defaults = {
        "num_particles": 200,
        "process_noise": PoseStddev(position=0.01),
        "detection_noise": PoseStddev(position=0.02, rotation=0.09),
        "initial_noise": PoseStddev(position=0.16),
    }
    return ParticleFilterConfig(**{**defaults, **changes})


def _update(motion_model=None, **changes) -> ParticleFilterUpdate:
    return ParticleFilterUpdate(
        config=_config(**changes), motion_model=motion_model or FreeMotion()
    )


def _step(update, state, seen=None) -> FilterState:
    """One update of a period, with detections of objects by index."""
    end = PERIOD * (state.step[0] + 1)
    return update.Update(
        state,
        path=ControlPath(np.array([end - PERIOD, end]), np.zeros((2, 1))),
        detections=seen or {},
        scratch=update.MakeScratch(),
    )


def _seen(state, p, fraction=1.0, q=UNIT) -> StampedPose:
    """A detection in the next period."""
    time = PERIOD * (state.step[0] + fraction)
    return StampedPose(time, np.concatenate([q, p]))


def _cloud(mean, covariance, count) -> FilterState:
    """A track of one object that isn't turned."""
    rng = np.random.default_rng(6)
    state = MakeInitialState(count, NOMINAL)
    p = rng.multivariate_normal(mean, covariance, count)
    state.poses[:, 0] = np.concatenate([np.tile(UNIT, (count, 1)), p], axis=1)
    state.estimates[:, 0] = np.concatenate([UNIT, mean])
    state.num_estimates[:] = 1
    return state


def _moments(state: FilterState):
    """Mean and covariance of the first object's weighted positions."""
    p = state.poses[:, 0, 4:]
    mean = state.weights @ p
    return mean, np.einsum("m,mi,mj->ij", state.weights, p - mean, p - mean)


class ExactFilter:
    """The Gaussian posterior of the position at the end of each period.

    A detection within a period is of a point on the straight way between the
    positions at its ends, so both are estimated together.
    """

    def __init__(self, mean, covariance, config: ParticleFilterConfig):
        self.mean, self.covariance = mean, covariance
        self.noise = config.process_noise.position**2 / 3 * np.eye(3)
        self.error = config.detection_noise.position**2 * np.eye(3)

    def step(self, seen) -> None:
        P = self.covariance
        mean = np.concatenate([self.mean, self.mean + VELOCITY * PERIOD])
        covariance = np.block([[P, P], [P, P + self.noise]])
        for fraction, z in seen:
            H = np.hstack([(1 - fraction) * np.eye(3), fraction * np.eye(3)])
            S = H @ covariance @ H.T + self.error
            gain = covariance @ H.T @ np.linalg.inv(S)
            mean = mean + gain @ (z - H @ mean)
            covariance = covariance - gain @ H @ covariance
        self.mean, self.covariance = mean[3:], covariance[3:, 3:]


@pytest.mark.parametrize(
    "fractions",
    [
        pytest.param([(1.0,)] * 12, id="one at the end of each period"),
        pytest.param([(1.0, 1.0, 1.0)] * 12, id="three at the end"),
        pytest.param([(1.0,), (), ()] * 4, id="missing ones"),
        pytest.param([(0.2, 0.7), (0.4,), ()] * 4, id="within the period"),
    ],
)
def test_many_particles_agree_with_the_exact_filter(fractions):
    config = _config(num_particles=40_000)
    update = ParticleFilterUpdate(config=config, motion_model=FreeMotion())
    spread = np.array([[4.0, 1, 0], [1, 2, -1], [0, -1, 3]]) * 1e-4
    truth = np.array([0.3, 0.2, 0.1])
    state = _cloud(truth, spread, config.num_particles)
    exact = ExactFilter(*_moments(state), config)
    rng = np.random.default_rng(9)
    for stamps in fractions:
        seen = []
        for u in stamps:
            error = config.detection_noise.position * rng.standard_normal(3)
            seen.append((u, truth + u * VELOCITY * PERIOD + error))
        truth = truth + VELOCITY * PERIOD
        exact.step(seen)
        poses = [_seen(state, z, u) for u, z in seen]
        state = _step(update, state, {0: poses} if poses else {})
        mean, covariance = _moments(state)
        # Both in standard deviations of the exact posterior.
        whiten = np.linalg.inv(np.linalg.cholesky(exact.covariance))
        np.testing.assert_allclose(
            whiten @ (mean - exact.mean), 0, atol=0.07
        )
        np.testing.assert_allclose(
            whiten @ covariance @ whiten.T, np.eye(3), atol=0.08
        )
        np.testing.assert_allclose(state.estimates[0, 0, 4:], mean)


def test_first_particles_are_the_posterior_of_initial_spread_and_detections():
    config = _config(
        num_particles=3000, initial_noise=PoseStddev(position=0.03)
    )
    update = ParticleFilterUpdate(config=config, motion_model=FreeMotion())
    state = MakeInitialState(3000, NOMINAL)
    p = np.array([[0.51, 0.41, 0.12], [0.5, 0.4, 0.1]])
    state = _step(update, state, {0: [_seen(state, x) for x in p]})
    mean, covariance = _moments(state)
    # Around the last, in the plane; each detection counts.
    spread, error = 0.03**2 / 2, 0.02**2
    variance = 1 / (1 / spread + 2 / error)
    expected = variance * (p[1] / spread + (p[0] + p[1]) / error)
    np.testing.assert_allclose(
        mean[:2], expected[:2], atol=4 * np.sqrt(variance / 3000)
    )
    np.testing.assert_allclose(
        covariance[:2, :2], variance * np.eye(2), atol=0.1 * variance
    )
    np.testing.assert_array_equal(state.poses[:, 0, 6], p[1, 2])
    # They were chosen by the detections; these must not count twice.
    np.testing.assert_allclose(state.weights, 1 / 3000)


def test_first_orientations_are_the_posterior_of_spread_and_detection():
    initial = PoseStddev(position=0.0, rotation=0.43)
    update = _update(num_particles=3000, initial_noise=initial)
    state = MakeInitialState(3000, NOMINAL)
    q = quaternions.from_rotation_vector(np.array([0.3, 1.2, -0.5]))
    state = _step(update, state, {0: [_seen(state, np.zeros(3), q=q)]})
    angles = quaternions.angle_between(state.poses[:, 0, :4], q)
    stddev = 1 / np.hypot(1 / 0.43, 1 / 0.09)
    assert np.sqrt(np.mean(angles**2)) == pytest.approx(stddev, rel=0.05)
    assert quaternions.angle_between(state.estimates[0, 0, :4], q) < 0.01


def test_without_a_detection_there_is_only_a_prediction():
    update = _update(num_particles=20_000)
    before = _cloud(np.array([0.3, 0.2, 0.1]), 1e-4 * np.eye(3), 20_000)
    after = _step(update, before)
    np.testing.assert_array_equal(after.weights, np.full(20_000, 1 / 20_000))
    assert after.detected[0] == 0
    assert after.num_estimates[0] == 2
    assert after.detection_times[0] == before.detection_times[0]
    shift = after.poses[:, 0, 4:] - before.poses[:, 0, 4:]
    noise = 0.01 / np.sqrt(3)
    np.testing.assert_allclose(
        np.mean(shift, axis=0), VELOCITY * PERIOD, atol=4 * noise / 141
    )
    np.testing.assert_allclose(
        np.cov(shift.T), noise**2 * np.eye(3), atol=0.05 * noise**2
    )


def test_what_is_not_tracked_yet_keeps_its_nominal_pose():
    update, state = _update(), MakeInitialState(200, NOMINAL)
    for _ in range(3):
        state = _step(update, state)
        np.testing.assert_array_equal(state.poses, np.tile(NOMINAL, (200, 1, 1)))
        np.testing.assert_array_equal(state.estimates[0], NOMINAL)
        assert state.num_estimates[0] == 0
    assert state.step[0] == 3


def test_an_object_that_is_never_detected_does_not_influence_another():
    results = []
    for other in ([0.1, 0.2, 0.3], [5.0, -3.0, 1.0]):
        nominal = np.concatenate([NOMINAL, NOMINAL])
        nominal[1, 4:] = other
        update, state = _update(), MakeInitialState(200, nominal)
        for x in (0.1, 0.11, 0.12):
            state = _step(update, state, {0: [_seen(state, [x, 0, 0])]})
        np.testing.assert_array_equal(state.poses[:, 1], [nominal[1]] * 200)
        np.testing.assert_array_equal(state.num_estimates, [2, 0])
        np.testing.assert_array_equal(state.detected, [1, 0])
        results.append((state.poses[:, 0], state.weights))
    for first, second in zip(*results, strict=True):
        np.testing.assert_array_equal(first, second)


def test_an_update_leaves_its_input_as_it_is():
    state = _cloud(np.zeros(3), 1e-4 * np.eye(3), 200)
    # Far enough for the track to be lost, which changes most.
    state.disagreement[:] = 5.0
    for field in fields(state):
        getattr(state, field.name).setflags(write=False)
    after = _step(_update(), state, {0: [_seen(state, [0.3, 0, 0])]})
    assert after.disagreement[0, 0] == 0
    assert state.disagreement[0, 0] == 5


def test_equal_states_and_inputs_give_equal_states():
    state = _cloud(np.zeros(3), 1e-4 * np.eye(3), 200)
    seen = {0: [_seen(state, [0.01, 0, 0])]}
    first, again = (_step(_update(), state, seen) for _ in range(2))
    other = _step(_update(seed=1), state, seen)
    for field in fields(state):
        name = field.name
        np.testing.assert_array_equal(getattr(first, name), getattr(again, name))
    assert not np.any(first.poses[:, 0, 4:] == other.poses[:, 0, 4:])


def test_an_update_counts_and_keeps_the_last_estimate_and_stamp():
    update, state = _update(), MakeInitialState(200, NOMINAL)
    seen = [_seen(state, [0.5, 0.4, 0.1], u) for u in (0.2, 0.6)]
    first = _step(update, state, {0: seen})
    second = _step(update, first)
    assert (first.step[0], second.step[0]) == (1, 2)
    assert first.detection_times[0] == seen[-1].time
    assert second.detection_times[0] == seen[-1].time
    assert (first.num_estimates[0], second.num_estimates[0]) == (1, 2)
    np.testing.assert_array_equal(second.estimates[1], first.estimates[0])
    np.testing.assert_array_equal(first.velocities, 0)


def test_a_failed_particle_costs_that_particle_only():
    failing = [0, 7]
    update = _update(FreeMotion(fails=failing), process_noise=PoseStddev())
    state = _cloud(np.zeros(3), 1e-6 * np.eye(3), 200)
    after = _step(update, state, {0: [_seen(state, VELOCITY * PERIOD)]})
    assert np.all(after.weights[failing] == 0)
    assert np.count_nonzero(after.weights) == 198
    survivors = _step(_update(process_noise=PoseStddev()), after).poses[:, 0]
    lost = after.poses[failing, 0, 4:] + VELOCITY * PERIOD
    assert not np.any(np.isin(survivors[:, 4:], lost))


def test_the_filter_goes_on_where_all_particles_fail():
    update = _update(FreeMotion(fails=range(200)))
    state = _cloud(np.zeros(3), 1e-6 * np.eye(3), 200)
    state = _step(update, state, {0: [_seen(state, [0.01, 0, 0])]})
    np.testing.assert_array_equal(state.weights, np.full(200, 1 / 200))
    assert np.all(np.isfinite(state.poses))


def _track_jump(update, num_updates: int) -> FilterState:
    """Detects the object half a meter from all of its particles."""
    state = _cloud(np.zeros(3), 1e-4 * np.eye(3), 200)
    for _ in range(num_updates):
        state = _step(update, state, {0: [_seen(state, [0.0, 0.5, 0.0])]})
    return state


def _distance(state: FilterState) -> float:
    return float(np.linalg.norm(state.estimates[0, 0, 4:] - [0.0, 0.5, 0.0]))


def test_a_lost_track_is_found_again_with_the_third_detection():
    update = _update(FreeMotion(np.zeros(3)))
    assert _distance(_track_jump(update, 2)) > 0.4
    state = _track_jump(update, 3)
    assert _distance(state) < 0.01
    np.testing.assert_array_equal(state.disagreement, 0)
    # Half of the particles were kept, in case that the detections are wrong.
    assert np.count_nonzero(state.poses[:, 0, 5] < 0.2) == 100


def test_a_lost_track_is_found_again_by_particles_that_all_fail():
    update = _update(FreeMotion(np.zeros(3), fails=range(200)))
    assert _distance(_track_jump(update, 3)) < 0.01


def test_a_track_stays_lost_if_it_is_not_to_be_recovered():
    update = _update(FreeMotion(np.zeros(3)), recover_lost_tracks=False)
    assert _distance(_track_jump(update, 6)) > 0.3


@pytest.mark.parametrize("size", [0.5, 100.0])
def test_one_outlier_does_not_draw_particles_anew(size):
    update = _update(FreeMotion(np.zeros(3)))
    state = _cloud(np.zeros(3), 1e-4 * np.eye(3), 200)
    for p in ([0, 0, 0], [size, 0, 0], [0, 0, 0], [0, 0, 0]):
        state = _step(update, state, {0: [_seen(state, p)]})
        assert np.max(np.abs(state.poses[:, 0, 4:])) < 0.1


# A roof between the camera and the table. Seen from there, it hides the table
# around x = 0.6.
ROOF = """
- add_model: {name: roof, file: package://scene/roof.sdf}
- add_weld:
    parent: world
    child: roof::roof
    X_PC: {translation: [0.5, 0.0, 0.5]}
"""
ROOF_SDF = """<?xml version="1.0"?>
<sdf version="1.7"><model name="roof"><link name="roof">
  <collision name="roof">
    <geometry><box><size>0.2 0.4 0.01</size></box></geometry>
  </collision>
</link></model></sdf>
"""
SHOWN, HIDDEN = [0.1, 0.2, 0.0065], [0.63, 0.0, 0.0065]


@pytest.fixture(scope="module")
def roofed(tmp_path_factory):
    """The visibility of two blocks, which a roof may hide."""
    folder = tmp_path_factory.mktemp("roofed")
    (folder / "roof.sdf").write_text(ROOF_SDF)
    scene = write_blocks_scene(
        folder, {"one": SHOWN, "two": HIDDEN}, more=ROOF
    )
    return VisibilityModel(scene=scene, num_rays=30)


THRESHOLDS = (
    VisibilityConfig(high_weight=0.7, low_weight=0.2, penalty=0.4),
    VisibilityConfig(high_weight=0.9, low_weight=0.6, penalty=0.1),
)


def _seeing_update(visibility) -> ParticleFilterUpdate:
    return ParticleFilterUpdate(
        config=_config(num_particles=4, process_noise=PoseStddev()),
        motion_model=FreeMotion(np.zeros(3)),
        visibility_model=visibility,
        visibility_configs=THRESHOLDS,
    )


def _state_of_two() -> FilterState:
    """All four combinations of what is hidden of two objects."""
    state = MakeInitialState(4, np.tile(NOMINAL, (2, 1)))
    state.num_estimates[:] = 2
    state.poses[:, 0, 4:] = [SHOWN, SHOWN, HIDDEN, HIDDEN]
    state.poses[:, 1, 4:] = [SHOWN, HIDDEN, SHOWN, HIDDEN]
    # Apart, so that they don't hide each other.
    state.poses[:, 1, 5] -= 0.1
    return state


def _see(visibility, state, seen=None) -> FilterState:
    """The robot's probe is far from everything."""
    end = PERIOD * (state.step[0] + 1)
    update = _seeing_update(visibility)
    path = ControlPath(np.array([end - PERIOD, end]), np.array([[0, -0.6]] * 2))
    return update.Update(
        state, path=path, detections=seen or {}, scratch=update.MakeScratch()
    )


def test_hidden_particles_are_preferred_where_nothing_is_detected(roofed):
    state = _see(roofed, _state_of_two())
    one, two = THRESHOLDS
    factors = np.outer(
        [one.low_weight, one.high_weight], [two.low_weight, two.high_weight]
    )
    np.testing.assert_allclose(
        state.weights, factors.ravel() / np.sum(factors), rtol=1e-12
    )


def test_hidden_particles_are_penalised_where_something_is_detected(roofed):
    before = _state_of_two()
    # Equally far from all particles, so that only visibility counts.
    middle = (np.array(SHOWN) + HIDDEN) / 2
    state = _see(roofed, before, {0: [_seen(before, middle)]})
    one, two = THRESHOLDS
    factors = np.outer([1, one.penalty], [two.low_weight, two.high_weight])
    np.testing.assert_allclose(
        state.weights, factors.ravel() / np.sum(factors), rtol=1e-9
    )


def test_visibility_of_what_is_not_tracked_yet_does_not_count(roofed):
    before = _state_of_two()
    before = replace(before, num_estimates=np.array([2.0, 0.0]))
    weights = _see(roofed, before).weights
    one = THRESHOLDS[0]
    factors = np.array([one.low_weight] * 2 + [one.high_weight] * 2)
    np.testing.assert_allclose(weights, factors / np.sum(factors), rtol=1e-12)
