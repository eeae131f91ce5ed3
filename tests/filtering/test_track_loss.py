import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2
from update_fixtures import NOMINAL, make_config

from pbpf_drake.filtering.filter_state import MakeInitialState, StampedPose
from pbpf_drake.filtering.particle_history import ParticleHistory
from pbpf_drake.filtering.track_loss import (
    is_lost,
    mean_disagreement,
    watch_tracks,
)
from pbpf_drake.filtering.update_step import make_update_step
from pbpf_drake.motion.control_path import ControlPath

STDDEV = 0.02
# Six particles, whose covariance is SPREAD² along each axis, about MEAN.
SPREAD = 0.015
MEAN = np.array([0.4, -0.1, 0.05])
CLOUD = MEAN + SPREAD * np.sqrt(3) * np.concatenate([np.eye(3), -np.eye(3)])
ZERO = np.zeros(3)
# What the running mean adds of the latest disagreement.
GAIN = 0.25


def _compare(offsets, last=ZERO, cloud=CLOUD, support=ZERO):
    detections = np.mean(cloud, axis=0) + np.atleast_2d(offsets)
    return mean_disagreement(last, cloud, detections, STDDEV, support)


def test_disagreement_is_the_offset_in_standard_deviations_of_both():
    offset = np.array([0.01, -0.02, 0.005])
    expected = GAIN * offset / np.hypot(SPREAD, STDDEV)
    np.testing.assert_allclose(_compare(offset), expected, rtol=1e-12)


def test_several_detections_count_as_their_mean_with_a_smaller_deviation():
    offsets = np.array([[0.01, 0.0, 0.0], [0.03, 0.0, 0.0], [0.02, 0.03, 0]])
    expected = GAIN * np.array([0.02, 0.01, 0])
    expected /= np.hypot(SPREAD, STDDEV / np.sqrt(3))
    np.testing.assert_allclose(_compare(offsets), expected, atol=1e-12)


def test_size_of_the_disagreement_has_the_spread_of_its_direction():
    cloud = MEAN + (CLOUD - MEAN) * [4.0, 1.0, 1.0]
    turn = Rotation.from_rotvec([0.3, -1.1, 0.4])
    turned = MEAN + turn.apply(cloud - MEAN)
    along, across = turn.apply([[0.04, 0, 0], [0, 0.04, 0]])
    for offset, spread in ((along, 4 * SPREAD), (across, SPREAD)):
        size = np.linalg.norm(_compare(offset, cloud=turned))
        assert size == pytest.approx(GAIN * 0.04 / np.hypot(spread, STDDEV))


def test_running_mean_forgets():
    last = np.array([0.5, -0.2, 0.1])
    np.testing.assert_allclose(_compare(ZERO, last), (1 - GAIN) * last)


def test_detections_without_error_leave_the_mean_at_zero():
    assert np.linalg.norm(_compare(ZERO)) < 1e-12
    assert not is_lost(ZERO)


def test_particles_that_are_all_the_same_can_be_compared():
    value = _compare([0.01, 0, 0], cloud=np.tile(MEAN, (5, 1)))
    np.testing.assert_allclose(value, [GAIN * 0.01 / STDDEV, 0, 0], atol=1e-12)
    one = _compare([0.01, 0, 0], cloud=MEAN[None])
    np.testing.assert_allclose(one, value)


def test_lost_is_what_chance_does_once_in_nine_times():
    # With this deviation along each axis: that of the mean of an intact track.
    stddev = np.sqrt(GAIN / (2 - GAIN))
    edge = stddev * np.sqrt(chi2.isf(1 / 9, df=3))
    for direction in ([1, 0, 0], [0, -1, 0], [0.6, 0, 0.8]):
        assert not is_lost(0.99 * edge * np.array(direction))
        assert is_lost(1.01 * edge * np.array(direction))


@pytest.mark.parametrize("size", [0.1, 1.0, 100.0, 1e6])
def test_one_outlier_never_shows_a_loss_however_large(size):
    value = _compare([size, -size, size])
    for _ in range(20):
        assert not is_lost(value)
        value = _compare(ZERO, value)


@pytest.mark.parametrize("size", [0.2, 1e6])
def test_three_outliers_that_agree_show_a_loss_but_not_two(size):
    value = ZERO
    for expected in (False, False, True):
        value = _compare([0, size, 0], value)
        assert is_lost(value) is expected


def test_three_outliers_that_do_not_agree_show_no_loss():
    value = ZERO
    for offset in np.eye(3):
        value = _compare(offset, value)
        assert not is_lost(value)


def test_small_errors_that_stay_show_a_loss_after_a_while():
    offset, value = [1.6 * np.hypot(SPREAD, STDDEV), 0, 0], ZERO
    lost = []
    for _ in range(30):
        value = _compare(offset, value)
        lost.append(is_lost(value))
    assert not any(lost[:3])
    assert all(lost[10:])


def _false_alarms(outliers: float, steps: int) -> float:
    """The share of alarms in a simulated intact track.

    Truth and particles are drawn from one distribution. After an alarm the
    mean starts anew, as it does in the filter.
    """
    rng = np.random.default_rng(8)
    clouds = SPREAD * rng.standard_normal((steps, 70, 3))
    detections = SPREAD * rng.standard_normal((steps, 1, 3))
    detections = detections + STDDEV * rng.standard_normal((steps, 2, 3))
    wrong = rng.random(steps) < outliers
    detections[wrong] += rng.uniform(-1, 1, (np.count_nonzero(wrong), 1, 3))
    value, alarms = ZERO, 0
    for cloud, seen in zip(clouds, detections, strict=True):
        value = mean_disagreement(value, cloud, seen, STDDEV, ZERO)
        if is_lost(value):
            value, alarms = ZERO, alarms + 1
    return alarms / steps


def test_alarms_of_an_intact_track_are_rare():
    # The mean is independent only every few updates, and starts at zero after
    # an alarm: fewer than χ² alone would give.
    assert _false_alarms(outliers=0.0, steps=10_000) < 1 / 15


def test_outliers_hardly_add_to_the_alarms():
    assert _false_alarms(outliers=0.05, steps=10_000) < 1 / 15


def test_what_a_support_prevents_is_no_disagreement():
    """A detector may report what stands on a table as if it floated."""
    up = np.array([0.0, 0.0, 1.0])
    found = _compare([0.02, -0.01, 0.07], support=up)
    np.testing.assert_allclose(found, _compare([0.02, -0.01, 0.0]), atol=1e-9)


def _watch(detections, *, state=None, **changes):
    """Watches an object that moved by 1 m along x in a second.

    Args:
        detections: stamps, x and turns about z.
        state: before it.
        changes: of the config.
    """
    if state is None:
        state = MakeInitialState(5, NOMINAL)
        state.num_estimates[:] = 1
    times = np.array([0.0, 0.9, 1.0])
    poses = np.tile(NOMINAL, (3, 5, 1, 1))
    poses[..., 4] = times[:, None, None]
    seen = []
    for time, x, turn in detections:
        pose = NOMINAL[0].copy()
        pose[[0, 3]] = np.cos(turn / 2), np.sin(turn / 2)
        pose[4] = x
        seen.append(StampedPose(time, pose))
    path = ControlPath(np.array([0.9, 1.0]), np.zeros((2, 1)))
    return watch_tracks(
        state,
        ParticleHistory(times, poses),
        np.zeros((5, 1, 3)),
        make_update_step(state, seed=0, path=path, detections={0: seen}),
        make_config(**changes),
    )


def test_a_late_detection_is_compared_with_where_particles_were():
    watch = _watch([(0.25, 0.25, 0.0)])
    np.testing.assert_allclose(watch.disagreement, 0.0, atol=1e-12)
    assert watch.num_rejected == [0]
    assert _watch([(0.25, 1.0, 0.0)]).num_rejected == [1]


def test_outliers_in_a_row_are_counted_until_one_agrees():
    off, on = (1.0, 3.0, 0.0), (1.0, 1.0, 0.0)
    assert _watch([off, off, off]).num_rejected == [3]
    assert _watch([off, off, on]).num_rejected == [0]
    assert _watch([on, off]).num_rejected == [1]


def test_a_track_is_lost_if_all_rotations_are_far_off():
    turned = [(1.0, 1.0, 3.0)] * 8
    assert _watch(turned, recover_lost_tracks=True).lost == [True]
    assert _watch(turned[1:], recover_lost_tracks=True).lost == [False]
    watch = _watch(turned, recover_lost_tracks=False)
    assert watch.lost == [False] and watch.num_rejected == [8]


def test_what_is_said_of_a_lost_track_begins_anew():
    watch = _watch([(1.0, 3.0, 0.0)] * 8, recover_lost_tracks=True)
    assert watch.num_rejected == [0]
    np.testing.assert_array_equal(watch.disagreement, np.zeros((1, 3)))
