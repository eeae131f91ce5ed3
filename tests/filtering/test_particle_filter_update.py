from dataclasses import fields

import numpy as np
import pytest
from update_fixtures import (
    NOMINAL,
    PERIOD,
    VELOCITY,
    FreeMotion,
    make_cloud,
    make_update,
    see,
    step,
)

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.filtering.filter_state import FilterState, MakeInitialState
from pbpf_drake.filtering.resampling import effective_sample_size


def test_without_a_detection_there_is_only_a_prediction():
    update = make_update(num_particles=20_000)
    before = make_cloud(np.array([0.3, 0.2, 0.1]), 1e-4 * np.eye(3), 20_000)
    after = step(update, before)
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
    update, state = make_update(), MakeInitialState(200, NOMINAL)
    for _ in range(3):
        state = step(update, state)
        np.testing.assert_array_equal(
            state.poses, np.tile(NOMINAL, (200, 1, 1))
        )
        np.testing.assert_array_equal(state.estimates[0], NOMINAL)
        assert state.num_estimates[0] == 0
    assert state.step[0] == 3


def test_an_object_that_is_never_detected_does_not_influence_another():
    results = []
    for other in ([0.1, 0.2, 0.3], [5.0, -3.0, 1.0]):
        nominal = np.concatenate([NOMINAL, NOMINAL])
        nominal[1, 4:] = other
        update, state = make_update(), MakeInitialState(200, nominal)
        for x in (0.1, 0.11, 0.12):
            state = step(update, state, {0: [see(state, [x, 0, 0])]})
        np.testing.assert_array_equal(state.poses[:, 1], [nominal[1]] * 200)
        np.testing.assert_array_equal(state.num_estimates, [2, 0])
        np.testing.assert_array_equal(state.detected, [1, 0])
        results.append((state.poses[:, 0], state.weights))
    for first, second in zip(*results, strict=True):
        np.testing.assert_array_equal(first, second)


def test_an_update_leaves_its_input_as_it_is():
    state = make_cloud(np.zeros(3), 1e-4 * np.eye(3), 200)
    # Far enough for the track to be lost, which changes most.
    state.disagreement[:] = 5.0
    for field in fields(state):
        getattr(state, field.name).setflags(write=False)
    update = make_update(recover_lost_tracks=True)
    after = step(update, state, {0: [see(state, [0.3, 0, 0])]})
    assert after.disagreement[0, 0] == 0
    assert state.disagreement[0, 0] == 5


def test_equal_states_and_inputs_give_equal_states():
    state = make_cloud(np.zeros(3), 1e-4 * np.eye(3), 200)
    seen = {0: [see(state, [0.01, 0, 0])]}
    first, again = (step(make_update(), state, seen) for _ in range(2))
    other = step(make_update(seed=1), state, seen)
    for field in fields(state):
        name = field.name
        np.testing.assert_array_equal(
            getattr(first, name), getattr(again, name)
        )
    assert not np.any(first.poses[:, 0, 4:] == other.poses[:, 0, 4:])


def test_an_update_counts_and_keeps_the_last_estimate_and_stamp():
    update, state = make_update(), MakeInitialState(200, NOMINAL)
    seen = [see(state, [0.5, 0.4, 0.1], u) for u in (0.2, 0.6)]
    first = step(update, state, {0: seen})
    second = step(update, first)
    assert (first.step[0], second.step[0]) == (1, 2)
    assert first.detection_times[0] == seen[-1].time
    assert second.detection_times[0] == seen[-1].time
    assert (first.num_estimates[0], second.num_estimates[0]) == (1, 2)
    np.testing.assert_array_equal(second.estimates[1], first.estimates[0])
    np.testing.assert_array_equal(first.velocities, 0)


def test_a_failed_particle_costs_that_particle_only():
    failing = [0, 7]
    update = make_update(FreeMotion(fails=failing), process_noise=PoseStddev())
    state = make_cloud(np.zeros(3), 1e-6 * np.eye(3), 200)
    after = step(update, state, {0: [see(state, VELOCITY * PERIOD)]})
    assert np.all(after.weights[failing] == 0)
    assert np.count_nonzero(after.weights) == 198
    survivors = step(make_update(process_noise=PoseStddev()), after).poses[:, 0]
    lost = after.poses[failing, 0, 4:] + VELOCITY * PERIOD
    assert not np.any(np.isin(survivors[:, 4:], lost))


def test_the_filter_goes_on_where_all_particles_fail():
    update = make_update(FreeMotion(fails=range(200)))
    state = make_cloud(np.zeros(3), 1e-6 * np.eye(3), 200)
    state = step(update, state, {0: [see(state, [0.01, 0, 0])]})
    np.testing.assert_array_equal(state.weights, np.full(200, 1 / 200))
    assert np.all(np.isfinite(state.poses))


def _track_jump(update, num_updates: int) -> FilterState:
    """Detects the object half a meter from all of its particles."""
    state = make_cloud(np.zeros(3), 1e-4 * np.eye(3), 200)
    state.velocities[:] = 1.0
    for _ in range(num_updates):
        seen = see(state, [0.0, 0.5, 0.0], fraction=0.3)
        state = step(update, state, {0: [seen]})
    return state


def _distance(state: FilterState) -> float:
    return float(np.linalg.norm(state.estimates[0, 0, 4:] - [0.0, 0.5, 0.0]))


def _recovering(**changes):
    return make_update(
        FreeMotion(np.zeros(3), **changes), recover_lost_tracks=True
    )


def test_a_lost_track_is_found_again_with_the_third_detection():
    update = _recovering()
    assert _distance(_track_jump(update, 2)) > 0.4
    state = _track_jump(update, 3)
    assert _distance(state) < 0.01
    np.testing.assert_array_equal(state.disagreement, 0)
    # Half of the particles were kept, in case that the detections are wrong.
    kept = state.poses[:, 0, 5] < 0.2
    assert np.count_nonzero(kept) == 100
    np.testing.assert_array_equal(state.velocities[kept], 1)
    # The others are not taken to have moved there.
    np.testing.assert_array_equal(state.velocities[~kept], 0)
    assert effective_sample_size(state.weights) > 20


def test_a_lost_track_is_found_again_by_particles_that_all_fail():
    update = _recovering(fails=range(200))
    assert _distance(_track_jump(update, 3)) < 0.01


def test_a_track_stays_lost_if_it_is_not_to_be_recovered():
    update = make_update(FreeMotion(np.zeros(3)))
    assert _distance(_track_jump(update, 7)) > 0.3


@pytest.mark.parametrize("size", [0.5, 100.0])
def test_one_outlier_does_not_draw_particles_anew(size):
    update = _recovering()
    state = make_cloud(np.zeros(3), 1e-4 * np.eye(3), 200)
    for p in ([0, 0, 0], [size, 0, 0], [0, 0, 0], [0, 0, 0]):
        state = step(update, state, {0: [see(state, p)]})
        assert np.max(np.abs(state.poses[:, 0, 4:])) < 0.1


@pytest.mark.parametrize("delay", [0.0, 0.3, 1.7])
def test_a_late_detection_weighs_the_past_that_it_saw(delay):
    """The object moves by 18 mm in a period, and all detections are exact."""
    update = make_update(
        num_particles=2000,
        process_noise=PoseStddev(),
        detection_noise=PoseStddev(position=0.02, rotation=0.09),
    )
    state = MakeInitialState(2000, NOMINAL, history_length=12)
    rng = np.random.default_rng(1)
    state.poses[:, 0, 4:] += rng.normal(0.0, 0.03, (2000, 3))
    state.num_estimates[:] = 2
    truth = NOMINAL[0, 4:]
    for i in range(1, 25):
        time = PERIOD * i - delay
        seen = see(state, truth + VELOCITY * time, 1 - delay / PERIOD)
        state = step(update, state, {0: [seen]} if time >= 0 else {})
    expected = truth + VELOCITY * PERIOD * 24
    np.testing.assert_allclose(state.estimates[0, 0, 4:], expected, atol=0.004)


def test_of_what_is_older_than_all_memory_the_oldest_counts():
    update = make_update(num_particles=50, process_noise=PoseStddev())
    state = make_cloud(np.array([0.3, 0.2, 0.1]), 1e-4 * np.eye(3), 50)
    seen = see(state, [0.3, 0.2, 0.1], -100.0)
    after = step(update, state, {0: [seen]})
    assert np.isfinite(after.weights).all()
