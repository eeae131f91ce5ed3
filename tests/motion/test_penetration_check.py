import numpy as np
from physics_fixtures import HEIGHTS, Simulation, make_model, wall_at
import pytest

from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.motion.penetration import PenetrationResolver
from pbpf_drake.motion.penetration_check import PenetrationCheck

BOTH = np.array([True, True])


@pytest.fixture(scope="module")
def model():
    return make_model("block", "soup", fixed=wall_at(0.3))


@pytest.fixture(scope="module")
def check(model):
    return PenetrationCheck(model=model, contacts=FixedContacts(model))


def _crowd(num: int, seed: int) -> np.ndarray:
    """Objects near each other, the wall and the table, (M, 2, 7)."""
    rng = np.random.default_rng(seed)
    poses = np.zeros((num, 2, 7))
    poses[..., 0] = 1.0
    poses[..., 4] = rng.uniform(0.15, 0.28, (num, 2))
    poses[..., 5] = rng.uniform(-0.1, 0.1, (num, 2))
    poses[:, 0, 6] = HEIGHTS["block"]
    poses[:, 1, 6] = HEIGHTS["soup"]
    lift = rng.uniform(-5e-4, 3e-3, (num, 2))
    poses[..., 6] += np.where(rng.random((num, 2)) < 0.5, lift, 0.0)
    return poses


def test_whatever_would_be_pushed_is_found(model, check):
    simulation = Simulation(model)
    contact = simulation.contact
    resolver = PenetrationResolver(contact, FixedContacts(model))
    poses = _crowd(200, seed=0)
    found = check.MayPenetrate(poses, BOTH)
    start = simulation.plant.GetPositions(simulation.plant_context)
    q = np.tile(start, (len(poses), 1))
    q[:, contact.object_q] = poses
    after = resolver.PushOut(q, np.zeros((len(poses), 2, 3)))
    moved = (after != q).any(axis=1)
    assert not (moved & ~found).any()
    assert np.count_nonzero(moved) > 20
    assert np.count_nonzero(~found) > 20


def test_what_rests_apart_from_others_is_not_found(check):
    poses = np.zeros((2, 2, 7))
    poses[..., 0] = 1.0
    poses[..., 5] = [-0.3, 0.3]
    poses[:, 0, 6] = HEIGHTS["block"]
    poses[:, 1, 6] = 0.5
    assert not check.MayPenetrate(poses, BOTH).any()


def test_only_objects_that_are_tracked_count(check):
    poses = np.zeros((1, 2, 7))
    poses[..., 0] = 1.0
    poses[..., 6] = [-0.01, 0.5]
    assert check.MayPenetrate(poses, BOTH).all()
    assert not check.MayPenetrate(poses, np.array([False, True])).any()
