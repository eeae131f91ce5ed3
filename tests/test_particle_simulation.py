import numpy as np
from physics_fixtures import (
    AWAY,
    FLAT,
    GRAVITY,
    Simulation,
    make_model,
    straight_path,
)
import pytest

from pbpf_drake.particle_simulation import choose_time_step, simulate
from pbpf_drake.robot_links import RobotLinks


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
    assert found == pytest.approx(step)


def _simulate(simulation, velocities, time_step: float = 0.01):
    model = simulation.model
    links = RobotLinks(model=model).Motion(
        straight_path(AWAY, [0.1, 0.0]),
        model.diagram.plant().CreateDefaultContext(),
    )
    poses = np.array([[*FLAT, 0.0, 0.0, 2.0], [*FLAT, 0.5, 0.0, 3.0]])
    found = simulate(
        simulation.contact,
        simulation.simulator,
        poses=poses,
        velocities=velocities,
        links=links,
        time_step=time_step,
    )
    return poses, *found


def test_objects_in_the_air_fall():
    velocities = np.zeros((2, 6))
    velocities[1, 3:] = [0.5, -0.2, 1.0]
    simulation = Simulation(make_model("block", "soup"))
    start, poses, end = _simulate(simulation, velocities)
    gravity = np.array([0.0, 0.0, -GRAVITY])
    np.testing.assert_allclose(end[:, 3:], velocities[:, 3:] + 0.16 * gravity)
    # A step moves with the speed at its end.
    way = 0.16 * velocities[:, 3:] + 0.16 * (0.16 + 0.01) / 2 * gravity
    np.testing.assert_allclose(poses[:, 4:], start[:, 4:] + way)


def test_a_simulation_begins_where_it_is_told_whatever_was_before():
    velocities = np.zeros((2, 6))
    velocities[0, 3] = 0.3
    simulation = Simulation(make_model("block", "soup"))
    first = _simulate(simulation, velocities)
    _simulate(simulation, -velocities)
    for a, b in zip(first, _simulate(simulation, velocities), strict=True):
        np.testing.assert_array_equal(a, b)
