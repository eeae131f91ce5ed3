"""Particles must not suffer from each other, nor from what isn't tracked."""

import numpy as np
from physics_fixtures import (
    AWAY,
    CAN_UPRIGHT,
    FLAT,
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
from pbpf_drake.motion.physics_motion_model import PhysicsMotionModel


def _config(num_particles: int, **parameters) -> ParticleFilterConfig:
    return ParticleFilterConfig(num_particles=num_particles, **parameters)


BAD_STATES = {
    "position": ((4,), np.nan, (), 0.0),
    "quaternion": (slice(0, 4), np.nan, (), 0.0),
    "zero quaternion": (slice(0, 4), 0.0, (), 0.0),
    "infinite": (6, np.inf, (), 0.0),
    "velocity": ((), 0.0, 4, np.nan),
    "speed": ((), 0.0, 3, 1e6),
    "spin": ((), 0.0, 0, 1e6),
}


@pytest.mark.parametrize("state", BAD_STATES)
@pytest.mark.parametrize("parallelism", [1, 2])
def test_a_particle_that_fails_costs_only_itself(block, state, parallelism):
    config = _config(6, parallelism=parallelism)
    dut = PhysicsMotionModel(model=block, config=config)
    poses, path = blocks_in_the_way(6), straight_path(TOUCHING, [0.1, 0.0])
    velocities, scratch = still(poses), dut.MakeScratch()
    good = make_motion(poses, velocities, path)
    expected = dut.Propagate(good, dut.MakeScratch())
    assert not np.any(expected.failed)
    bad_poses, bad_velocities = poses.copy(), velocities.copy()
    pose_index, pose_value, velocity_index, velocity = BAD_STATES[state]
    if pose_index != ():
        bad_poses[2, 0, pose_index] = pose_value
    if velocity_index != ():
        bad_velocities[2, 0, velocity_index] = velocity
    bad = make_motion(bad_poses, bad_velocities, path)
    others = np.arange(6) != 2
    for _ in range(2):
        result = dut.Propagate(bad, scratch)
        np.testing.assert_array_equal(result.failed, ~others)
        assert_same(result, expected, others)
        np.testing.assert_array_equal(result.poses[2], bad_poses[2])
        assert_same(dut.Propagate(good, scratch), expected)


def test_a_particle_that_is_too_fast_has_failed(block):
    dut = PhysicsMotionModel(model=block, config=_config(3, max_speed=2.0))
    poses = blocks_on_table(3)
    poses[..., 6] = 10.0
    velocities = still(poses)
    velocities[:, 0, 3] = [1.9, 2.1, 1.0]
    velocities[:, 0, 5] = 0.16 * GRAVITY  # They end without falling.
    motion = make_motion(poses, velocities, straight_path(AWAY, [0.0, 0.0]))
    result = dut.Propagate(motion, dut.MakeScratch())
    np.testing.assert_array_equal(result.failed, [False, True, False])
    np.testing.assert_array_equal(result.poses[1], poses[1])


def _beside(poses: np.ndarray, pose, velocity) -> tuple:
    """Adds a second object that isn't tracked yet to every particle."""
    count = len(poses)
    both = np.concatenate([poses, np.tile(pose, (count, 1, 1))], axis=1)
    velocities = np.zeros((count, 2, 6))
    velocities[:, 1] = velocity
    return both, velocities


@pytest.mark.parametrize(
    ("pose", "velocity"),
    [
        ([*CAN_UPRIGHT, 0.0, 0.0, 0.05], 0.0),
        ([*CAN_UPRIGHT, 0.0, 0.0, 0.05], 50.0),
        ([*FLAT, 0.05, 0.0, 0.0], 1e6),
        ([np.nan] * 7, np.nan),
    ],
)
def test_an_object_that_is_not_tracked_yet_has_no_influence(
    two, pose, velocity
):
    dut = PhysicsMotionModel(model=two, config=_config(8))
    path, active = straight_path(TOUCHING, [0.1, 0.0]), np.array([True, False])
    results = []
    for p, v in ((pose, velocity), ([*FLAT, 5.0, 5.0, 5.0], 0.0)):
        poses, velocities = _beside(blocks_in_the_way(8), p, v)
        scratch = dut.MakeScratch()
        poses = dut.ResolvePenetration(
            poses, np.zeros((8, 2, 3)), TOUCHING, active, scratch
        )
        np.testing.assert_array_equal(poses[:, 1], np.tile(p, (8, 1)))
        motion = make_motion(poses, velocities, path, active=active)
        results.append(dut.Propagate(motion, scratch))
        np.testing.assert_array_equal(results[-1].poses[:, 1], poses[:, 1])
    assert not np.any(results[0].failed)
    for name in ("poses", "velocities", "supports"):
        first, second = (getattr(result, name)[:, 0] for result in results)
        np.testing.assert_array_equal(first, second)


def test_without_a_tracked_object_nothing_changes(block):
    dut = PhysicsMotionModel(model=block, config=_config(3))
    poses = np.tile([*FLAT, -0.05, 0.0, -0.02], (3, 1, 1))
    none, scratch = np.zeros(1, dtype=bool), dut.MakeScratch()
    path = straight_path(TOUCHING, [0.1, 0.0])
    motion = make_motion(poses, still(poses), path, active=none)
    result = dut.Propagate(motion, scratch)
    np.testing.assert_array_equal(result.poses, poses)
    np.testing.assert_array_equal(result.velocities, still(poses))
    assert not np.any(result.failed) and not np.any(result.supports)
    resolved = dut.ResolvePenetration(
        poses, np.zeros((3, 1, 3)), TOUCHING, none, scratch
    )
    np.testing.assert_array_equal(resolved, poses)


def test_an_object_that_waits_is_as_good_as_none(block, two):
    physics = exactly(friction=0.2, mass=0.5, dissipation=80.0)
    path = straight_path(TOUCHING, [0.1, 0.0])
    config = _config(8, physics=physics)
    alone = PhysicsMotionModel(model=block, config=config)
    poses = blocks_in_the_way(8)
    expected = alone.Propagate(
        make_motion(poses, still(poses), path), alone.MakeScratch()
    )
    dut = PhysicsMotionModel(model=two, config=config)
    poses, velocities = _beside(poses, [*FLAT, 0.0, 0.0, 0.0], 0.0)
    active = np.array([True, False])
    motion = make_motion(poses, velocities, path, active=active)
    result = dut.Propagate(motion, dut.MakeScratch())
    # Not to the bit: one more body changes when the solver is content.
    np.testing.assert_allclose(
        result.poses[:, 0], expected.poses[:, 0], atol=2e-5
    )
