import numpy as np
from physics_fixtures import make_model
from pydrake.multibody.tree import RigidBody
import pytest

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.motion.parameter_bank import DrawParameterBank
from pbpf_drake.motion.particle_physics import ParticlePhysics

NUM = 3


@pytest.fixture(scope="module")
def model():
    return make_model("block", "soup")


@pytest.fixture(scope="module")
def parameters():
    return DrawParameterBank(ParticleFilterConfig(num_particles=NUM), 2)


@pytest.fixture
def physics(model, parameters):
    return ParticlePhysics(model, parameters, FixedContacts(model))


def test_each_set_of_links_has_its_own_which_are_made_only_once(physics):
    assert physics.Plant((0,)).link_set == (0,)
    assert physics.Plant(()).link_set == ()
    for get in physics.Plant, physics.Resolver:
        assert get((0,)) is get((0,))
        assert get((0,)) is not get(())
    simulators = physics.Simulators((0,))
    assert simulators.Get(1) is physics.Simulators((0,)).Get(1)
    assert simulators.Get(1) is not physics.Simulators(()).Get(1)


def _mass(body: RigidBody, plant, simulator) -> float:
    context = plant.GetMyContextFromRoot(simulator.get_context())
    return body.get_mass(context)


def test_each_simulator_has_its_own_draw_of_the_parameters(physics, parameters):
    particle_plant = physics.Plant(())
    plant = particle_plant.diagram.plant()
    for draw in range(NUM):
        simulator = physics.Simulators(()).Get(draw)
        masses = [
            _mass(plant.get_body(index), plant, simulator)
            for index in particle_plant.objects
        ]
        np.testing.assert_allclose(masses, parameters.mass[draw])
