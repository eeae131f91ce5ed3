import numpy as np

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.motion.parameter_bank import DrawParameterBank, deal_parameters

CONFIG = ParticleFilterConfig(num_particles=50, seed=2)


def test_each_step_deals_every_draw_to_one_particle():
    dealt = [deal_parameters(CONFIG, step) for step in (1, 2)]
    for order in dealt:
        np.testing.assert_array_equal(np.sort(order), np.arange(50))
    assert np.any(dealt[0] != dealt[1])
    np.testing.assert_array_equal(deal_parameters(CONFIG, 2), dealt[1])


def test_draws_are_those_of_the_config_and_its_seed():
    bank = DrawParameterBank(CONFIG, 3)
    assert bank.friction.shape == bank.mass.shape == (50, 3)
    assert np.all(bank.mass >= CONFIG.physics.mass.min)
    again = DrawParameterBank(CONFIG, 3)
    np.testing.assert_array_equal(bank.friction, again.friction)
    other = DrawParameterBank(ParticleFilterConfig(num_particles=50), 3)
    assert np.any(bank.friction != other.friction)
