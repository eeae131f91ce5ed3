"""Objects that slide in the particles' plant stop where Coulomb says."""

import numpy as np
from physics_fixtures import CAN_UPRIGHT, FLAT, GRAVITY, HEIGHTS, Simulation
import pytest

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.motion.particle_simulation import choose_time_step
from pbpf_drake.poses import quaternions


def _slide(simulation, q_WO, z, *, speed, angle) -> np.ndarray:
    """Returns how far an object slides until it stops, (2,)."""
    simulation.settle(q_WO, [0.0, 0.0, z])
    start = simulation.pose()[4:6]
    direction = np.array([np.cos(angle), np.sin(angle), 0.0])
    simulation.set_velocity([0.0, 0.0, 0.0, *(speed * direction)])
    simulation.advance(0.8)
    assert np.linalg.norm(simulation.velocity()) < 5e-3
    return simulation.pose()[4:6] - start


UPRIGHT_BOX = quaternions.from_rotation_vector(
    np.deg2rad(120.0) * np.array([-1, -1, -1]) / np.sqrt(3)
)
SLIDERS = [
    ("cracker", FLAT, HEIGHTS["cracker"]),
    ("cracker", UPRIGHT_BOX, 0.08),
    ("soup", CAN_UPRIGHT, HEIGHTS["soup"]),
]


@pytest.mark.parametrize(("name", "q_WO", "z"), SLIDERS)
@pytest.mark.parametrize("friction", [0.2, 0.3, 0.4])
@pytest.mark.parametrize(
    ("speed", "angle"), [(0.5, 0), (0.6, 0.5), (0.9, np.pi)]
)
def test_objects_slide_as_far_as_coulomb_says(
    models, name, q_WO, z, friction, speed, angle
):
    """With the steps that the filter would take."""
    config = ParticleFilterConfig()
    time_step = choose_time_step(
        np.array(speed),
        max_travel=config.max_travel,
        max_step=config.time_step,
    )
    simulation = Simulation(
        models(name), time_step=float(time_step), friction=friction
    )
    moved = _slide(simulation, q_WO, z, speed=speed, angle=angle)
    distance = speed**2 / (2 * friction * GRAVITY)
    direction = np.array([np.cos(angle), np.sin(angle)])
    assert np.linalg.norm(moved) == pytest.approx(distance, rel=0.05)
    assert moved @ direction == pytest.approx(np.linalg.norm(moved), rel=1e-3)


@pytest.mark.parametrize(("name", "q_WO", "z"), SLIDERS)
@pytest.mark.parametrize("time_step", [0.005, 0.01, 0.02])
def test_what_is_missing_is_half_a_step_of_the_initial_speed(
    models, name, q_WO, z, time_step
):
    """The integrator uses the speed at the end of a step."""
    simulation = Simulation(models(name), time_step=time_step, friction=0.4)
    moved = _slide(simulation, q_WO, z, speed=0.5, angle=0.5)
    distance = 0.5**2 / (2 * 0.4 * GRAVITY) - 0.5 * time_step / 2
    assert np.linalg.norm(moved) == pytest.approx(distance, rel=0.03)
