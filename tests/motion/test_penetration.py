import numpy as np
from physics_fixtures import (
    CAN_UPRIGHT,
    FLAT,
    HEIGHTS,
    PROBE_RADIUS,
    Simulation,
    make_model,
    wall_at,
)
import pytest

from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.motion.penetration import PenetrationResolver
from pbpf_drake.poses import quaternions
from pbpf_drake.shapes.contact_points import REST_DEPTH

HALF_BLOCK = 0.045
REST = HEIGHTS["block"]
FAR = np.array([-0.7, 0.7])
TURNED = quaternions.from_rotation_vector(np.array([0.3, -0.2, 0.5]))


class _World:
    """Positions of a model that are pushed out, and what penetrates then."""

    def __init__(self, *names: str, fixed: str = "") -> None:
        self.simulation = Simulation(make_model(*names, fixed=fixed))
        self.model = self.simulation.contact
        self.context = self.simulation.context
        self.resolver = PenetrationResolver(
            self.model, FixedContacts(self.simulation.model)
        )

    def push(self, *poses, robot=FAR) -> np.ndarray:
        """Returns the objects' poses afterwards, (K, 7)."""
        self.simulation.set_robot(robot, [0.0, 0.0])
        q = self.simulation.plant.GetPositions(self.simulation.plant_context)
        q[self.model.object_q] = poses
        before = q.copy()
        (after,) = self.resolver.PushOut(q[None], np.zeros((1, len(poses), 3)))
        np.testing.assert_array_equal(q, before)
        np.testing.assert_array_equal(
            after[self.model.link_q], before[self.model.link_q]
        )
        found = after[self.model.object_q]
        np.testing.assert_array_equal(found[:, :4], np.array(poses)[:, :4])
        self.simulation.plant.SetPositions(self.simulation.plant_context, after)
        return found

    def depth(self) -> float:
        """The deepest penetration at the positions that push returned.

        What is at rest on something may be as deep as that takes.
        """
        scene_graph = self.model.diagram.scene_graph()
        query = scene_graph.get_query_output_port().Eval(
            scene_graph.GetMyContextFromRoot(self.context)
        )
        pairs = query.ComputePointPairPenetration()
        return max(
            (
                pair.depth - 1.25 * REST_DEPTH * abs(pair.nhat_BA_W[2])
                for pair in pairs
            ),
            default=0.0,
        )


@pytest.fixture(scope="module")
def block():
    return _World("block")


@pytest.fixture(scope="module")
def two():
    return _World("block", "soup")


def test_what_penetrates_nothing_is_not_moved(block):
    pose = [*TURNED, 0.2, 0.1, 0.2]
    (after,) = block.push(pose)
    np.testing.assert_array_equal(after, pose)


def test_what_rests_on_the_table_is_not_moved(block):
    pose = [*FLAT, 0.2, 0.1, REST - 5e-5]
    (after,) = block.push(pose)
    np.testing.assert_array_equal(after, pose)


@pytest.mark.parametrize("depth", [2e-4, 1e-3, 5e-3, 2e-2])
def test_a_block_in_the_table_is_lifted(block, depth):
    (after,) = block.push([*FLAT, 0.2, 0.1, REST - depth])
    np.testing.assert_allclose(after[4:], [0.2, 0.1, REST], atol=2e-4)
    assert block.depth() < 2e-4


def test_a_tilted_block_in_the_table_is_lifted_without_turning(block):
    (after,) = block.push([*TURNED, 0.2, 0.1, 0.0])
    half = np.array([HALF_BLOCK, HALF_BLOCK, REST])
    axes = quaternions.rotate(quaternions.conjugate(TURNED), [0, 0, 1])
    lowest = after[6] - np.abs(axes) @ half
    assert abs(lowest) < 2.1e-4
    np.testing.assert_allclose(after[4:6], [0.2, 0.1], atol=1e-12)


@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0])
@pytest.mark.parametrize("depth", [1e-3, 1e-2])
def test_a_block_in_the_probe_is_pushed_off_its_face(block, angle, depth):
    q = quaternions.from_rotation_vector(np.array([0.0, 0.0, angle]))
    away = quaternions.rotate(q, np.array([1.0, 0.0, 0.0]))
    gap = PROBE_RADIUS + HALF_BLOCK
    start = away * (gap - depth) + [0.0, 0.0, REST]
    (after,) = block.push([*q, *start], robot=np.zeros(2))
    np.testing.assert_allclose(after[4:], start + depth * away, atol=2e-4)
    assert block.depth() < 2e-4


def test_a_block_in_probe_and_table_leaves_both(block):
    start = [PROBE_RADIUS + HALF_BLOCK - 4e-3, 0.0, REST - 3e-3]
    (after,) = block.push([*FLAT, *start], robot=np.zeros(2))
    assert block.depth() < 2e-4
    expected = [PROBE_RADIUS + HALF_BLOCK, 0.0, REST]
    np.testing.assert_allclose(after[4:], expected, atol=3e-4)


def test_a_can_in_the_table_is_lifted(two):
    block = [*FLAT, -0.3, 0.0, REST]
    _, can = two.push(block, [*CAN_UPRIGHT, 0.2, 0.1, 0.045])
    np.testing.assert_allclose(can[4:], [0.2, 0.1, 0.05], atol=2e-4)


def test_two_objects_share_the_way_equally(two):
    radius, depth = 0.03383, 4e-3
    x = HALF_BLOCK + radius - depth
    z = HEIGHTS["soup"] + REST  # Its lower rim is at half the block's height.
    block, can = two.push([*FLAT, 0.0, 0.0, REST], [*CAN_UPRIGHT, x, 0.0, z])
    # The points stick out of the shapes.
    depth += REST_DEPTH
    np.testing.assert_allclose(block[4], -depth / 2, atol=2e-4)
    np.testing.assert_allclose(can[4], x + depth / 2, atol=2e-4)
    np.testing.assert_allclose(block[5:], [0.0, REST], atol=2e-4)
    assert two.depth() < 2e-4


def test_between_their_points_two_objects_touch_with_their_cores(two):
    """A block's edge at half the height of a can: each gives 1 mm."""
    radius, depth, inset = 0.03383, 4e-3, 1e-3
    x = HALF_BLOCK + radius - depth
    block, can = two.push([*FLAT, 0, 0, 0.1], [*CAN_UPRIGHT, x, 0, 0.1])
    room = can[4] - block[4] - HALF_BLOCK - radius
    assert room == pytest.approx(-2 * inset, abs=2e-4)


def test_an_object_between_two_others_makes_way():
    """The probe, a block, a can and a wall in a row, all too close."""
    world = _World("block", "soup", fixed=wall_at(0.2))
    wall, radius = 0.2, 0.03383
    can = [wall - radius + 3e-3, 0.0, 0.05]
    block = [can[0] - radius - HALF_BLOCK + 3e-3, 0.0, REST]
    probe = [block[0] - HALF_BLOCK - PROBE_RADIUS - 6e-3, 0.0]
    after = world.push([*FLAT, *block], [*CAN_UPRIGHT, *can], robot=probe)
    # 6 mm of penetration find 6 mm of room: it is enough for all.
    assert world.depth() < 3e-4
    assert after[1, 4] < wall - radius + 3e-4


@pytest.mark.parametrize("stands", [True, False])
def test_what_stands_on_something_is_slid_not_lifted(block, stands):
    """A probe that leans over a block touches its upper edge."""
    model, tilt = block.model, -0.4
    start = block.simulation.plant.GetPositions(block.simulation.plant_context)
    lean = quaternions.from_rotation_vector(np.array([0.0, tilt, 0.0]))
    start[model.link_q[0]] = [*lean, 0.0, 0.0, 0.0]
    x = HALF_BLOCK + PROBE_RADIUS / np.cos(tilt) - 6e-3
    start[model.object_q[0]] = [*FLAT, x, 0.0, REST]
    support = np.array([[[0.0, 0.0, float(stands)]]])
    (end,) = block.resolver.PushOut(start[None], support)
    moved = (end - start)[model.object_q[0, 4:]]
    assert moved[0] > 1e-3
    assert abs(moved[1]) < 1e-12
    assert (abs(moved[2]) < 1e-12) == stands


@pytest.mark.parametrize("offset", [-0.03, 0.03])
def test_what_is_pushed_off_its_centre_turns_as_by_a_push(block, offset):
    """A square of side a pushed at b from its centre: δ b / (a²/6 + b²)."""
    model, depth = block.model, 1e-3
    q = block.simulation.plant.GetPositions(block.simulation.plant_context)
    q[model.link_q[0]] = [*FLAT, 0.0, offset, 0.0]
    x = PROBE_RADIUS + HALF_BLOCK - depth
    q[model.object_q[0]] = [*FLAT, x, 0.0, REST]
    (after,) = block.resolver.PushOut(q[None], np.array([[[0.0, 0.0, 1.0]]]))
    block.simulation.plant.SetPositions(block.simulation.plant_context, after)
    assert block.depth() < 2e-4
    pose = after[model.object_q[0]]
    turn = quaternions.to_rotation_vector(pose[:4])
    # The push comes from the left: above the centre it turns clockwise.
    expected = -depth * offset / ((2 * HALF_BLOCK) ** 2 / 6 + offset**2)
    # All but the 0.08 mm that are left.
    np.testing.assert_allclose(turn, [0.0, 0.0, expected], rtol=0.15, atol=1e-9)
    assert pose[6] == REST


def test_particles_are_pushed_as_one_by_one(two):
    model, rng = two.model, np.random.default_rng(0)
    start = two.simulation.plant.GetPositions(two.simulation.plant_context)
    start[model.link_q[0]] = [*FLAT, 0.0, 0.0, 0.0]
    q = np.tile(start, (30, 1))
    q[:, model.object_q[0]] = [*FLAT, 0.05, 0.0, REST]
    q[:, model.object_q[1]] = [*CAN_UPRIGHT, 0.12, 0.0, HEIGHTS["soup"]]
    q[:, model.object_q[:, 4:6]] += rng.normal(0, 0.02, (30, 2, 2))
    up = np.tile([0.0, 0.0, 1.0], (30, 2, 1))
    together = two.resolver.PushOut(q, up)
    assert np.count_nonzero((together != q).any(axis=1)) > 10
    for m in range(30):
        (alone,) = two.resolver.PushOut(q[m : m + 1], up[m : m + 1])
        np.testing.assert_allclose(together[m], alone, rtol=0, atol=1e-12)


def test_a_row_of_objects_is_pushed_through_at_once(two):
    """What the probe has pushed isn't pushed back by what it pushes."""
    model = two.model
    x = HALF_BLOCK + PROBE_RADIUS
    block = [x - 5e-3, 0.0, REST]
    can = [x - 5e-3 + HALF_BLOCK + 0.03383 - 1e-3, 0.0, HEIGHTS["soup"]]
    q = two.simulation.plant.GetPositions(two.simulation.plant_context)
    q[model.link_q[0]] = [*FLAT, 0.0, 0.0, 0.0]
    q[model.object_q] = [[*FLAT, *block], [*CAN_UPRIGHT, *can]]
    (after,) = two.resolver.PushOut(q[None], np.zeros((1, 2, 3)))
    two.simulation.plant.SetPositions(two.simulation.plant_context, after)
    assert two.depth() < 1.5e-4
    moved = (after - q)[model.object_q[:, 4]]
    assert moved[0] == pytest.approx(5e-3, abs=2e-4)
    # Their cores are 1 mm smaller.
    assert 3.5e-3 < moved[1] < 6.5e-3
