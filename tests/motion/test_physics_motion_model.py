import numpy as np
from physics_fixtures import (
    AWAY,
    GRAVITY,
    TOUCHING,
    assert_same,
    blocks_in_the_way,
    blocks_on_table,
    exactly,
    make_motion,
    still,
    straight_path,
)
import pytest

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.motion.physics_motion_model import PhysicsMotionModel


def _config(num_particles: int, **parameters) -> ParticleFilterConfig:
    return ParticleFilterConfig(num_particles=num_particles, **parameters)


def test_every_draw_is_dealt_to_one_particle_anew_at_every_step(block):
    dut = PhysicsMotionModel(model=block, config=_config(50))
    for step in range(5):
        assert sorted(dut.assignment(step)) == list(range(50))
    twin = PhysicsMotionModel(model=block, config=_config(50, parallelism=2))
    other = PhysicsMotionModel(model=block, config=_config(50, seed=1))
    np.testing.assert_array_equal(dut.assignment(3), twin.assignment(3))
    assert np.any(dut.assignment(3) != dut.assignment(4))
    assert np.any(dut.assignment(3) != other.assignment(3))


def test_parameters_are_drawn_per_particle_and_object(two):
    parameters = PhysicsMotionModel(model=two, config=_config(9)).parameters()
    for name in "friction", "mass", "dissipation":
        assert getattr(parameters, name).shape == (9, 2)
        # Friction and mass have a share at their minimum.
        assert len(np.unique(getattr(parameters, name))) > 9
    other = PhysicsMotionModel(model=two, config=_config(9, seed=1))
    assert np.any(other.parameters().mass != parameters.mass)


def test_particles_are_predicted_with_the_parameters_they_are_dealt(block):
    """Blocks that slide lose speed as Coulomb says, each by its own θ."""
    dut = PhysicsMotionModel(model=block, config=_config(40))
    parameters, dealt = dut.parameters(), dut.assignment(7)
    poses = blocks_on_table(40)
    velocities = still(poses)
    velocities[..., 3] = 1.0
    result = dut.Propagate(
        make_motion(poses, velocities, straight_path(AWAY, [0.0, 0.0]), step=7),
        dut.MakeScratch(),
    )
    friction = parameters.friction[dealt, 0]
    expected = np.maximum(1.0 - friction * GRAVITY * 0.16, 0.0)
    np.testing.assert_allclose(result.velocities[:, 0, 3], expected, atol=0.02)
    assert np.ptp(expected) > 0.5


@pytest.mark.parametrize("friction", [0.2, 0.4])
def test_blocks_slide_as_far_as_coulomb_says(block, friction):
    config = _config(3, physics=exactly(friction=friction))
    dut = PhysicsMotionModel(model=block, config=config)
    poses = blocks_on_table(3)
    velocities = still(poses)
    velocities[..., 3:5] = [0.54, -0.72]
    path = straight_path(AWAY, [0.0, 0.0], duration=0.48)
    result = dut.Propagate(
        make_motion(poses, velocities, path), dut.MakeScratch()
    )
    moved = result.poses[:, 0, 4:6] - poses[:, 0, 4:6]
    distance = 0.9**2 / (2 * friction * GRAVITY)
    np.testing.assert_allclose(
        moved, np.tile([0.6, -0.8], (3, 1)) * distance, rtol=0.05
    )
    np.testing.assert_allclose(result.supports[:, 0], [[0, 0, 1]] * 3)


def test_results_depend_on_neither_processes_nor_memory(block):
    poses, path = blocks_in_the_way(24), straight_path(TOUCHING, [0.1, 0.0])
    motion = make_motion(poses, still(poses), path, step=5)
    junk = make_motion(
        poses + 0.01, still(poses) + 1.0, straight_path(AWAY, [1.0, 0.0])
    )
    one = PhysicsMotionModel(model=block, config=_config(24))
    two = PhysicsMotionModel(model=block, config=_config(24, parallelism=2))
    expected = one.Propagate(motion, one.MakeScratch())
    assert np.ptp(expected.poses[:, 0, 4]) > 1e-3
    for dut in one, two:
        scratch = dut.MakeScratch()
        assert_same(dut.Propagate(motion, scratch), expected)
        dut.Propagate(junk, scratch)
        dut.ResolvePenetration(
            poses - 0.005,
            np.zeros((24, 1, 3)),
            AWAY,
            np.ones(1, dtype=bool),
            scratch,
        )
        assert_same(dut.Propagate(motion, scratch), expected)


@pytest.mark.parametrize(
    ("time_step", "duration"), [(0.01, 0.01), (0.16, 0.16), (1.0, 0.16)]
)
def test_a_motion_of_a_single_step_leaves_no_memory(block, time_step, duration):
    config = _config(4, time_step=time_step)
    dut = PhysicsMotionModel(model=block, config=config)
    path = straight_path(AWAY, [0.0, 0.0], duration=duration)
    poses, scratch = blocks_on_table(4), dut.MakeScratch()
    moving = still(poses) + [0, 0, 0, 0.3, 0.2, 1.0]
    motion = make_motion(poses, moving, path)
    expected = dut.Propagate(motion, dut.MakeScratch())
    dut.Propagate(make_motion(poses, still(poses), path), scratch)
    assert_same(dut.Propagate(motion, scratch), expected)


def test_what_the_robot_did_within_the_period_counts(block):
    """A poke ends where it began; the block is gone."""
    out_and_back = ControlPath(
        np.linspace(0.0, 0.16, 9),
        TOUCHING + np.outer([0, 3, 6, 9, 12, 9, 6, 3, 0], [1e-3, 0.0]),
    )
    physics = exactly(friction=0.8)
    dut = PhysicsMotionModel(model=block, config=_config(2, physics=physics))
    poses = blocks_on_table(2)
    motion = make_motion(poses, still(poses), out_and_back)
    result = dut.Propagate(motion, dut.MakeScratch())
    moved = result.poses[:, 0, 4] - poses[:, 0, 4]
    # It slides on for less than 0.15² / (2 · 0.8 · 9.81) = 1.4 mm.
    np.testing.assert_array_less(0.0115, moved)
    np.testing.assert_array_less(moved, 0.0145)


def test_the_robot_ends_where_its_path_ends(block):
    rng = np.random.default_rng(0)
    q = TOUCHING + np.cumsum(rng.uniform(-0.004, 0.006, (9, 2)), axis=0)
    path = ControlPath(np.linspace(3.0, 3.16, 9), q)
    dut = PhysicsMotionModel(model=block, config=_config(6))
    poses, scratch = blocks_in_the_way(6), dut.MakeScratch()
    dut.Propagate(make_motion(poses, still(poses), path), scratch)
    links = scratch.crew.worker.Simulators((0,))
    for m in range(6):
        context = links.Get(m).get_context()
        x = context.get_continuous_state_vector().CopyToVector()
        np.testing.assert_allclose(x[4:6], q[-1], atol=1e-5)


def test_a_path_of_one_point_takes_no_time(block):
    dut = PhysicsMotionModel(model=block, config=_config(3))
    poses = blocks_on_table(3)
    velocities = still(poses) + 0.1
    path = ControlPath(np.array([2.0]), AWAY[None])
    motion = make_motion(poses, velocities, path)
    result = dut.Propagate(motion, dut.MakeScratch())
    np.testing.assert_allclose(result.poses, poses, atol=1e-15)
    np.testing.assert_array_equal(result.velocities, velocities)
    np.testing.assert_allclose(result.supports[:, 0], [[0, 0, 1]] * 3)
