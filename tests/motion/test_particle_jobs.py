from dataclasses import replace

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
from pbpf_drake.motion.particle_groups import ParticleGroup
from pbpf_drake.motion.particle_jobs import (
    PushOutJob,
    RunOnCrew,
    SimulationJob,
)
from pbpf_drake.motion.particle_physics import ParticlePhysics
from pbpf_drake.process_crew import Crew

NUM = 8
PROBE = (0,)


@pytest.fixture(scope="module")
def block():
    return make_model("block")


def _physics(model) -> ParticlePhysics:
    config = ParticleFilterConfig(num_particles=NUM)
    parameters = DrawParameterBank(config, 1)
    return ParticlePhysics(model, parameters, FixedContacts(model))


def _job(model) -> SimulationJob:
    """Returns the job of all particles, each with a draw of its own."""
    poses = blocks_in_the_way(NUM)
    return SimulationJob(
        link_set=PROBE,
        link_motion=link_motion(model, straight_path(TOUCHING, [0.1, 0.0])),
        poses=poses,
        velocities=still(poses),
        active=np.ones(1, dtype=bool),
        time_steps=np.full(NUM, 2.0**-5),
        max_travel=1e-3,
        draws=np.arange(NUM),
    )


def _simulate(physics, model, rows, *, link_set=PROBE, draws=None):
    """Returns where the particles of some rows go, poses and velocities."""
    job = _job(model).of(ParticleGroup(link_set, np.asarray(rows)))
    if draws is not None:
        job = replace(job, draws=np.asarray(draws))
    result = job.RunOn(physics)
    return result.poses, result.velocities


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


def test_only_the_links_of_the_job_push(block):
    physics = _physics(block)
    pushed, _ = _simulate(physics, block, range(NUM))
    left, _ = _simulate(physics, block, range(NUM), link_set=())
    start = blocks_in_the_way(NUM)
    assert np.all(pushed[:, 0, 4] - start[:, 0, 4] > 1e-3)
    np.testing.assert_allclose(left[..., 4:6], start[..., 4:6], atol=1e-5)


def test_what_penetrates_is_pushed_out_by_the_links_of_the_job(block):
    physics, start = _physics(block), blocks_in_the_way(NUM)
    start[::2, 0, 4] -= 0.012  # 2 to 12 mm into the probe.
    everyone = PushOutJob(
        link_set=PROBE,
        link_poses=_job(block).link_motion.poses[0],
        poses=start,
        supports=np.tile([0.0, 0.0, 1.0], (NUM, 1, 1)),
    )
    for links in PROBE, ():
        job = everyone.of(ParticleGroup(links, np.arange(NUM)))
        moved = np.any(job.RunOn(physics) != start, axis=(1, 2))
        assert list(moved) == [bool(links) and m % 2 == 0 for m in range(NUM)]


def test_the_part_of_a_group_has_its_particles_and_its_links(block):
    job, group = _job(block), ParticleGroup((), np.array([6, 1]))
    part = job.of(group)
    assert part.link_set == ()
    assert part.link_motion.poses.shape[1:] == (0, 7)
    for name in "poses", "velocities", "time_steps", "draws":
        np.testing.assert_array_equal(
            getattr(part, name), getattr(job, name)[[6, 1]]
        )


def test_a_crew_says_whose_result_is_whose(block):
    crew, job = Crew(_physics(block), 2), _job(block)
    expected, _ = _simulate(_physics(block), block, range(NUM))
    shares = [
        [
            ParticleGroup(PROBE, np.array([4, 0])),
            ParticleGroup(PROBE, np.array([7])),
        ],
        [ParticleGroup(PROBE, np.array([2, 1, 3]))],
    ]
    found = list(RunOnCrew(crew, shares, job.of))
    members = [list(m) for m, _ in found]
    assert members == [[4, 0], [7], [2, 1, 3]]
    for m, result in found:
        np.testing.assert_array_equal(result.poses, expected[m])
