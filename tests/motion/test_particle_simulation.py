import numpy as np
from physics_fixtures import (
    AWAY,
    FLAT,
    GRAVITY,
    HEIGHTS,
    Simulation,
    link_motion,
    make_model,
    straight_path,
)
import pytest

from pbpf_drake.motion.particle_simulation import (
    MakeFallLimit,
    choose_time_step,
    make_states,
    simulate,
    split_states,
)
from pbpf_drake.motion.ticks import to_ticks


@pytest.mark.parametrize(
    ("speed", "step"),
    [
        (0.0, 0.016),
        (0.05, 0.016),
        (0.125, 0.008),
        (0.5, 0.002),
        (100.0, 0.001),
    ],
)
def test_steps_are_as_long_as_the_travel_lets_them_be(speed, step):
    found = choose_time_step(np.array(speed), max_travel=1e-3, max_step=0.016)
    # To a multiple of 8 ticks of a microsecond.
    assert found == pytest.approx(step, abs=4e-6)


def _fall_limit(simulation, max_travel: float = 1.0):
    active = np.ones(len(simulation.contact.objects), dtype=bool)
    return MakeFallLimit(simulation.contact, active, max_travel)


def _simulate(simulation, velocities, time_step: float = 0.01):
    links = link_motion(simulation.model, straight_path(AWAY, [0.1, 0.0]))
    poses = np.array([[*FLAT, 0.0, 0.0, 2.0], [*FLAT, 0.5, 0.0, 3.0]])
    (state,) = make_states(
        simulation.contact,
        poses=poses[None],
        velocities=velocities[None],
        link_motion=links,
    )
    (step,) = choose_time_step(np.zeros(1), max_travel=1e-3, max_step=time_step)
    end = simulate(
        simulation.contact,
        simulation.simulator,
        state=state,
        link_motion=links,
        time_step=step,
        fall_limit=_fall_limit(simulation),
    )
    found = split_states(simulation.contact, end[None])
    return poses, *(values[0] for values in found)


def test_objects_in_the_air_fall():
    velocities = np.zeros((2, 6))
    velocities[1, 3:] = [0.5, -0.2, 1.0]
    simulation = Simulation(make_model("block", "soup"))
    start, poses, end = _simulate(simulation, velocities)
    gravity = np.array([0.0, 0.0, -GRAVITY])
    expected = velocities[:, 3:] + 0.16 * gravity
    np.testing.assert_allclose(end[:, 3:], expected, atol=1e-4)
    # A step moves with the speed at its end; the first is divided.
    steps = np.array([0.01 / 8, 0.01 / 4, 0.01 * 5 / 8, *[0.01] * 15])
    way = 0.16 * velocities[:, 3:]
    way = way + np.sum(steps * np.cumsum(steps)) * gravity
    np.testing.assert_allclose(poses[:, 4:], start[:, 4:] + way, atol=1e-5)


def test_a_simulation_begins_where_it_is_told_whatever_was_before():
    velocities = np.zeros((2, 6))
    velocities[0, 3] = 0.3
    simulation = Simulation(make_model("block", "soup"))
    first = _simulate(simulation, velocities)
    _simulate(simulation, -velocities)
    for a, b in zip(first, _simulate(simulation, velocities), strict=True):
        np.testing.assert_array_equal(a, b)


def test_the_time_that_a_simulator_has_gone_makes_no_difference():
    """Not to the last bit, whatever it has simulated before."""
    fresh, used = (Simulation(make_model("block", "soup")) for _ in range(2))
    rng = np.random.default_rng(0)
    for _ in range(7):
        _simulate(used, rng.normal(size=(2, 6)), time_step=0.0123)
    velocities = rng.normal(size=(2, 6))
    for a, b in zip(
        _simulate(fresh, velocities), _simulate(used, velocities), strict=True
    ):
        np.testing.assert_array_equal(a, b)


def test_the_links_are_where_the_path_ends():
    simulation = Simulation(make_model("block", "soup"))
    _simulate(simulation, np.zeros((2, 6)))
    np.testing.assert_allclose(
        simulation.links()[0, 4:6], AWAY + [0.016, 0.0], atol=1e-6
    )


@pytest.mark.parametrize(("max_travel", "sinks"), [(1.0, True), (1e-3, False)])
def test_what_falls_takes_shorter_steps(max_travel, sinks):
    """A block falls 20 mm onto the table, which takes 64 ms."""
    simulation = Simulation(make_model("block"))
    path = straight_path(AWAY, [0.0, 0.0], duration=0.08)
    links = link_motion(simulation.model, path)
    height = HEIGHTS["block"] + 0.02
    (state,) = make_states(
        simulation.contact,
        poses=np.array([[[*FLAT, 0.0, 0.0, height]]]),
        velocities=np.zeros((1, 1, 6)),
        link_motion=links,
    )
    end = simulate(
        simulation.contact,
        simulation.simulator,
        state=state,
        link_motion=links,
        time_step=float(to_ticks(0.04)),
        fall_limit=_fall_limit(simulation, max_travel),
    )
    poses, _ = split_states(simulation.contact, end[None])
    assert (poses[0, 0, 6] < HEIGHTS["block"] - 5e-3) == sinks


def test_the_steps_of_what_falls_have_a_shortest():
    simulation = Simulation(make_model("block", "soup"))
    simulation.set_velocity([0, 0, 0, 0, 0, -0.1], k=0)
    simulation.set_velocity([0, 0, 0, 0, 0, -5.0], k=1)
    step = float(to_ticks(0.04))
    for active, travel, expected in (
        ([True, False], 4.1e-3, step),
        ([True, False], 2e-3, 0.02),
        ([True, True], 2e-3, 0.01),
        ([False, False], 2e-3, step),
    ):
        limit = MakeFallLimit(simulation.contact, np.array(active), travel)
        found = limit.TimeStep(simulation.context, step)
        assert found == pytest.approx(expected, abs=1e-6)
    limit = MakeFallLimit(simulation.contact, np.array([True, False]), 1e-3)
    state = simulation.context.get_continuous_state_vector().CopyToVector()
    state[limit.rows] = np.nan
    simulation.context.SetContinuousState(state)
    assert limit.TimeStep(simulation.context, step) == step
