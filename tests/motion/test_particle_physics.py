import numpy as np
from physics_fixtures import (
    TOUCHING,
    blocks_in_the_way,
    link_motion,
    make_model,
    still,
    straight_path,
)
import pytest

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.motion.parameter_bank import DrawParameterBank
from pbpf_drake.motion.particle_physics import ParticlePhysics

NUM = 8
PROBE = (0,)


@pytest.fixture(scope="module")
def block():
    return make_model("block")


def _physics(model) -> ParticlePhysics:
    config = ParticleFilterConfig(num_particles=NUM)
    parameters = DrawParameterBank(config, 1)
    return ParticlePhysics(model, parameters, FixedContacts(model))


def _links(model):
    return link_motion(model, straight_path(TOUCHING, [0.1, 0.0]))


def _simulate(physics, model, rows, *, chosen=PROBE, draws=None):
    poses = blocks_in_the_way(NUM)
    return physics.Simulate(
        chosen,
        poses=poses[rows],
        velocities=still(poses)[rows],
        links=_links(model).of(chosen),
        time_steps=np.full(len(rows), 2.0**-5),
        active=np.ones(1, dtype=bool),
        max_travel=1e-3,
        draws=np.asarray(rows if draws is None else draws),
    )


def test_particles_go_where_they_would_go_alone_in_any_order(block):
    physics, everyone = _physics(block), list(range(NUM))
    together = _simulate(physics, block, everyone)
    mixed = [5, 2, 7, 0]
    for found, expected in zip(
        _simulate(physics, block, mixed), together, strict=True
    ):
        np.testing.assert_array_equal(found, expected[mixed])
    for m in everyone:
        alone = _simulate(_physics(block), block, [m])
        np.testing.assert_array_equal(alone[0][0], together[0][m])


def test_the_draw_of_the_parameters_makes_the_difference(block):
    physics = _physics(block)
    one = _simulate(physics, block, [0] * NUM, draws=range(NUM))
    assert len(np.unique(one[0][:, 0, 4])) == NUM
    same = _simulate(physics, block, [0] * NUM, draws=[3] * NUM)
    assert len(np.unique(same[0][:, 0, 4])) == 1


def test_only_the_links_that_are_chosen_push(block):
    physics = _physics(block)
    pushed, _ = _simulate(physics, block, range(NUM))
    left, _ = _simulate(physics, block, range(NUM), chosen=())
    start = blocks_in_the_way(NUM)
    assert np.all(pushed[:, 0, 4] - start[:, 0, 4] > 1e-3)
    np.testing.assert_allclose(left[..., 4:6], start[..., 4:6], atol=1e-5)


def test_what_penetrates_is_pushed_out_by_the_links_that_are_chosen(block):
    physics, start = _physics(block), blocks_in_the_way(NUM)
    start[::2, 0, 4] -= 0.012  # 2 to 12 mm into the probe.
    links = _links(block).poses[0]
    for chosen in PROBE, ():
        found = physics.PushOut(
            chosen,
            link_poses=links[list(chosen)],
            poses=start,
            supports=np.tile([0.0, 0.0, 1.0], (NUM, 1, 1)),
        )
        moved = np.any(found != start, axis=(1, 2))
        assert list(moved) == [bool(chosen) and m % 2 == 0 for m in range(NUM)]
