"""Updates with as many particles as are needed, or as there is time for."""

from dataclasses import fields, replace
import time

from filter_fixtures import (
    PERIOD,
    FilterRun,
    block_at,
    detections,
    planar_scene,
    probe_at,
    small_config,
)
import numpy as np
from pydrake.systems.analysis import Simulator
import pytest
from update_fixtures import (
    NOMINAL,
    FreeMotion,
    make_cloud,
    make_config,
    make_update,
    see,
    step,
)

from pbpf_drake.config.adaptive_count_config import AdaptiveCountConfig
from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.filtering.add_particle_filter import AssembleParticleFilter
from pbpf_drake.filtering.filter_state import MakeInitialState
from pbpf_drake.filtering.resampling import effective_sample_size
from pbpf_drake.scene.prediction_model import MakePredictionModel

ADAPTIVE = AdaptiveCountConfig(to_belief=True, min_particles=20)
M = 200
STILL = np.zeros(3)


class _CountingMotion(FreeMotion):
    """Notes how many particles it gets."""

    def __init__(self, **options):
        super().__init__(STILL, **options)
        self.counts = []

    def Propagate(self, motion, scratch):
        self.counts.append(len(motion.poses))
        return super().Propagate(motion, scratch)

    def ResolvePenetration(self, poses, *arguments):
        assert len(poses) == self.counts[-1]
        return super().ResolvePenetration(poses, *arguments)


class _SlowMotion(_CountingMotion):
    """Takes half a millisecond per particle."""

    def Propagate(self, motion, scratch):
        time.sleep(5e-4 * len(motion.poses))
        return super().Propagate(motion, scratch)


def _check(state) -> None:
    """Asserts what holds for the state after any update."""
    count = int(state.num_used[0])
    assert len(state.weights) == len(state.poses) == len(state.velocities)
    assert np.sum(state.weights) == pytest.approx(1)
    np.testing.assert_array_equal(state.weights[count:], 0)
    assert 1 <= effective_sample_size(state.weights) <= count * (1 + 1e-12)
    for values in (state.poses, state.velocities):
        assert np.all(np.isfinite(values))
        np.testing.assert_array_equal(values, np.resize(
            values[:count], values.shape))  # fmt: skip


def _run(update, state, num_steps, seen=None):
    """The numbers of particles of some updates, and the last state."""
    counts = []
    for _ in range(num_steps):
        measured = {0: [see(state, seen)]} if seen is not None else {}
        state = step(update, state, measured)
        _check(state)
        counts.append(int(state.num_used[0]))
    return counts, state


def test_a_track_begins_with_all_and_needs_few_once_it_is_localized():
    motion = _CountingMotion()
    update = make_update(
        motion,
        adaptive_count=ADAPTIVE,
        process_noise=PoseStddev(position=0.0005),
    )
    state = MakeInitialState(M, NOMINAL)
    counts, state = _run(update, state, 40, seen=[0.3, 0.2, 0.1])
    assert counts[0] == M
    assert max(counts[-4:]) <= 25
    # Without detections, all that are left are worth the same.
    more, _ = _run(update, state, 2)
    assert more[-1] == 20
    counts += more
    # What isn't used isn't simulated.
    assert motion.counts == counts
    np.testing.assert_allclose(
        state.estimates[0, 0, 4:], [0.3, 0.2, 0.1], atol=0.01
    )


def test_a_belief_that_spreads_out_needs_more_and_more():
    update = make_update(
        _CountingMotion(),
        adaptive_count=ADAPTIVE,
        detection_noise=PoseStddev(position=0.01, rotation=0.09),
    )
    state = make_cloud(STILL, 1e-8 * np.eye(3), M)
    counts, state = _run(update, state, 25)
    assert counts[0] == 20
    assert counts[-1] == M
    assert np.all(np.diff(counts) > -30)
    # And few again, when the object is seen.
    counts, _ = _run(update, state, 8, seen=state.estimates[0, 0, 4:])
    assert counts[-1] < M / 2


def _mean_square_spread(to_belief: bool) -> float:
    """Of a belief that spreads out, over many seeds."""
    squares = []
    for seed in range(40):
        update = make_update(
            _CountingMotion(),
            adaptive_count=replace(ADAPTIVE, to_belief=to_belief),
            seed=seed,
        )
        state = make_cloud(STILL, 1e-6 * np.eye(3), M)
        counts, state = _run(update, state, 6)
        assert (counts[0] < M) == to_belief
        p = state.poses[:, 0, 4:] - state.estimates[0, 0, 4:]
        squares.append(state.weights @ np.sum(p**2, axis=-1))
    return float(np.mean(squares))


def test_a_belief_spreads_out_as_it_does_with_all_particles():
    expected = 3e-6 + 6 * 0.01**2
    assert _mean_square_spread(False) == pytest.approx(expected, rel=0.05)
    # With n particles, 1/n of the spread is lost at each update.
    assert _mean_square_spread(True) == pytest.approx(expected, rel=0.15)


def test_where_all_are_needed_nothing_changes():
    every = replace(ADAPTIVE, max_divergence=1e-6, bin_position=1e-6)
    states = []
    for adaptive in (AdaptiveCountConfig(), every):
        update = make_update(adaptive_count=adaptive)
        state = make_cloud(STILL, 1e-4 * np.eye(3), M)
        states.append(_run(update, state, 3, seen=STILL)[1])
    for field in fields(states[0]):
        np.testing.assert_array_equal(
            *(getattr(state, field.name) for state in states)
        )


def test_a_collapse_of_the_weights_needs_all():
    """The few that survive are near to each other."""
    update = make_update(_CountingMotion(), adaptive_count=ADAPTIVE)
    state = make_cloud(STILL, 1e-8 * np.eye(3), M)
    even = step(update, state)
    assert even.num_used[0] == 20
    weights = np.eye(M)[7]
    assert step(update, replace(state, weights=weights)).num_used[0] == M


def test_a_second_object_that_begins_needs_all():
    update = make_update(_CountingMotion(), adaptive_count=ADAPTIVE)
    state = MakeInitialState(M, np.concatenate([NOMINAL, NOMINAL]))
    for _ in range(6):
        state = step(update, state, {0: [see(state, STILL)]})
    assert state.num_used[0] < M
    state = step(update, state, {1: [see(state, STILL)]})
    assert state.num_used[0] == M


@pytest.mark.parametrize("most, used", [(1, 20), (33, 33), (1000, M)])
def test_an_update_has_at_most_what_it_may_have(most, used):
    update = make_update(_CountingMotion())
    state = make_cloud(STILL, 1e-4 * np.eye(3), M)
    state = step(update, state, most=most)
    _check(state)
    assert state.num_used[0] == used


@pytest.mark.parametrize("num_failing", [1, 20])
def test_particles_that_are_not_used_do_not_stand_in_for_failed_ones(
    num_failing,
):
    motion = _CountingMotion(fails=range(num_failing))
    update = make_update(motion, adaptive_count=ADAPTIVE)
    state = make_cloud(STILL, 1e-8 * np.eye(3), M)
    counts, state = _run(update, state, 1)
    assert counts == [20]
    # Where all fail, nothing is known: they have the same weight.
    left = 20 - num_failing or 20
    assert np.count_nonzero(state.weights) == left


def _make_timed(to_period: bool, seconds: list[float]):
    """A filter of 100 particles that takes 50 ms, with a period of 20 ms."""
    scene = planar_scene()
    config = make_config(
        num_particles=100,
        period=0.02,
        control_samples=1,
        adaptive_count=AdaptiveCountConfig(to_period=to_period),
    )
    dut = AssembleParticleFilter(
        scene=scene,
        config=config,
        model=MakePredictionModel(scene),
        motion_model=_SlowMotion(),
        on_update=seconds.append,
    )
    simulator = Simulator(dut)
    dut.GetInputPort("joint_positions").FixValue(
        simulator.get_mutable_context(), [0.0, 0.0]
    )
    return dut, simulator


@pytest.mark.parametrize("to_period", [False, True])
def test_particles_are_given_up_for_the_period_only_if_that_is_set(to_period):
    seconds: list[float] = []
    dut, simulator = _make_timed(to_period, seconds)
    port, counts = dut.GetOutputPort("particles_used"), []
    for i in range(8):
        simulator.AdvanceTo(0.02 * (i + 1.5))
        counts.append(port.Eval(simulator.get_context())[0])
    assert counts[0] == 100 and seconds[0] > 0.02
    if to_period:
        # 32 fit, if nothing but the motion takes time.
        assert all(20 <= n <= 32 for n in counts[1:])
        assert np.median(seconds[1:]) < 0.8 * seconds[0]
    else:
        assert counts == [100] * 8


def test_no_port_shows_what_is_not_used():
    scene = planar_scene()
    config = small_config(
        scene,
        num_particles=30,
        adaptive_count=replace(ADAPTIVE, min_particles=10, bin_position=0.1,
                               bin_rotation=1.0),
    )  # fmt: skip
    run, counts = FilterRun(scene, config), []
    for i in range(1, 6):
        run.set_joints(probe_at(i))
        run.measure(detections(PERIOD * i - 0.02, block=block_at(i)))
        run.update(i)
        ports = run.ports()
        for name, value in ports.items():
            assert np.all(np.isfinite(value)), name
        count = int(ports["particles_used"][0])
        assert count == 30 if i == 1 else 10 <= count <= 30
        counts.append(count)
        assert ports["effective_sample_size"] <= count * (1 + 1e-12)
        assert np.sum(ports["weights"]) == pytest.approx(1)
        np.testing.assert_array_equal(ports["weights"][count:], 0)
    assert min(counts) < 30
