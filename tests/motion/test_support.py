import numpy as np
from physics_fixtures import (
    CAN_UPRIGHT,
    FLAT,
    HEIGHTS,
    PROBE_RADIUS,
    Simulation,
    make_model,
)
import pytest

from pbpf_drake.motion.fixed_contacts import FixedContacts, PointContacts
from pbpf_drake.motion.support import find_supports, support_normals
from pbpf_drake.poses import quaternions

UP = np.array([0.0, 0.0, 1.0])
# How deep a thing at rest is in what it stands on.
SUNK = 3e-5
SLOPE = 0.25
RAMP = f"""
- add_model:
    name: ramp
    file: package://pbpf_drake/obstacles/scene_4_support.sdf
- add_weld:
    parent: world
    child: ramp::scene_4_support
    X_PC:
      translation: [0.0, 0.5, 0.3]
      rotation: !Rpy {{deg: [0.0, {np.rad2deg(SLOPE)}, 0.0]}}
"""


def _turn(x: float, y: float, z: float) -> np.ndarray:
    return quaternions.from_rotation_vector(np.array([x, y, z]))


@pytest.fixture(scope="module")
def simulation():
    return Simulation(make_model("block", "soup", fixed=RAMP))


def _found(simulation) -> np.ndarray:
    poses = np.array([[simulation.pose(k) for k in range(2)]])
    contacts = FixedContacts(simulation.model).Find(poses)
    (supports,) = find_supports(contacts, 1, 2)
    return supports


def _normal(points, normals) -> np.ndarray:
    """Returns what is found of one group of contacts, (3,)."""
    (normal,) = support_normals(
        np.array(points, float), np.array(normals, float), np.array([0])
    )
    return normal


def _contacts(rows) -> PointContacts:
    return PointContacts(*(np.array(c) for c in zip(*rows, strict=True)))


def _supports(simulation, block, can=(*FLAT, 0.0, 0.0, 2.0)) -> np.ndarray:
    simulation.set_pose(block[:4], block[4:], 0)
    simulation.set_pose(can[:4], can[4:], 1)
    return _found(simulation)


def test_three_points_of_a_plane_are_a_support():
    points = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]])
    normal = np.array([0.6, 0.0, 0.8])
    found = _normal(points, np.tile(normal, (3, 1)))
    np.testing.assert_allclose(found, normal)


def test_normals_that_differ_a_little_are_averaged():
    points = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0.1, 0.1, 0]])
    tilts = np.array([[0.01, 0], [-0.01, 0], [0, 0.01], [0, -0.01]])
    normals = np.column_stack([np.sin(tilts), np.cos(0.01 * np.ones(4))])
    np.testing.assert_allclose(_normal(points, normals), UP, atol=1e-12)


@pytest.mark.parametrize(
    ("points", "normals"),
    [
        # One point, or two, or three on a line: it can tip.
        ([[0, 0, 0]], [[0, 0, 1]]),
        ([[0, 0, 0], [0.1, 0, 0]], [[0, 0, 1]] * 2),
        ([[0, 0, 0], [0.1, 0.1, 0], [0.2, 0.2, 0]], [[0, 0, 1]] * 3),
        # A table and a wall: it can't slide along both.
        ([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], [[0, 0, 1]] * 2 + [[1, 0, 0]]),
        # Squeezed between two walls.
        (
            [[0, 0, 0], [0, 0.1, 0], [0.1, 0, 0], [0.1, 0.1, 0]],
            [[1, 0, 0]] * 2 + [[-1, 0, 0]] * 2,
        ),
        # A curved support: normals 0.1 rad apart.
        (
            [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]],
            [[0, 0, 1], [np.sin(0.1), 0, np.cos(0.1)], [0, 0, 1]],
        ),
    ],
)
def test_what_is_not_flat_is_no_support(points, normals):
    np.testing.assert_array_equal(_normal(points, normals), np.zeros(3))


def test_groups_of_contacts_do_not_influence_each_other():
    """In any order, each gets what it gets alone."""
    triangle = [np.eye(3)[i] for i in range(3)]
    groups = {
        (0, 1): [(point, UP) for point in triangle],
        (1, 0): [(point, -UP) for point in triangle],
        (2, 0): [(triangle[0], UP)],
        (2, 1): list(zip(triangle, np.eye(3), strict=True)),
    }
    contacts = [
        (m, k, point, normal, 1e-3)
        for (m, k), of_group in reversed(groups.items())
        for point, normal in of_group
    ]
    expected = np.zeros((4, 2, 3))
    expected[0, 1], expected[1, 0] = UP, -UP
    np.testing.assert_array_equal(
        find_supports(_contacts(contacts), 4, 2), expected
    )
    none = FixedContacts(make_model("block")).Find(np.full((2, 1, 7), np.nan))
    assert not np.any(find_supports(none, 2, 1))


@pytest.mark.parametrize("yaw", [0.0, 0.4, 2.0])
def test_a_block_that_lies_on_the_table_is_supported(simulation, yaw):
    z = HEIGHTS["block"] - SUNK
    block, _ = _supports(simulation, [*_turn(0, 0, yaw), 0.1, 0.2, z])
    np.testing.assert_allclose(block, UP, atol=1e-9)


def test_a_block_in_the_air_is_free(simulation):
    block, _ = _supports(simulation, [*FLAT, 0.1, 0.2, HEIGHTS["block"] + 9e-4])
    np.testing.assert_array_equal(block, np.zeros(3))


@pytest.mark.parametrize("turn", [(0, 0.01, 0), (0.01, 0.01, 0), (0, 0.8, 0)])
def test_a_block_on_an_edge_or_a_corner_is_free(simulation, turn):
    q = _turn(*turn)
    down = quaternions.rotate(quaternions.conjugate(q), UP)
    height = np.abs(down) @ [0.045, 0.045, 0.0065]
    block, _ = _supports(simulation, [*q, 0.1, 0.2, height - SUNK])
    np.testing.assert_array_equal(block, np.zeros(3))


def test_a_block_that_stands_on_its_side_is_supported(simulation):
    z = 0.045 - SUNK
    block, _ = _supports(simulation, [*_turn(np.pi / 2, 0, 0), 0.1, 0.2, z])
    np.testing.assert_allclose(block, UP, atol=1e-9)


def test_a_ramp_carries_along_its_own_normal(simulation):
    q = _turn(0.0, SLOPE, 0.0)
    normal = quaternions.rotate(q, UP)
    half = 0.1681 / 2 + HEIGHTS["block"] - SUNK
    start = np.array([0.0, 0.5, 0.3]) + half * normal
    block, _ = _supports(simulation, [*q, *start])
    np.testing.assert_allclose(block, normal, atol=1e-9)


def test_a_can_is_supported_where_it_stands_and_free_to_roll(simulation):
    away = [*FLAT, 0.0, -0.5, 1.0]
    z = HEIGHTS["soup"] - SUNK
    _, can = _supports(simulation, away, [*CAN_UPRIGHT, 0.1, 0.2, z])
    np.testing.assert_allclose(can, UP, atol=1e-9)
    radius, core = 0.03383, 0.03333
    for roll, height in ((0.0, radius), (np.pi / 8, core)):
        q = _turn(0.0, roll, 0.0)
        _, can = _supports(simulation, away, [*q, 0.1, 0.2, height - SUNK])
        np.testing.assert_array_equal(can, np.zeros(3))


def test_another_tracked_object_is_no_support(simulation):
    block = [*FLAT, 0.1, 0.2, HEIGHTS["block"] - SUNK]
    z = 0.013 + HEIGHTS["soup"] - 2 * SUNK
    supports = _supports(simulation, block, [*CAN_UPRIGHT, 0.1, 0.2, z])
    np.testing.assert_allclose(supports[0], UP, atol=1e-9)
    np.testing.assert_array_equal(supports[1], np.zeros(3))


def test_the_robot_is_no_support(simulation):
    """The block is on the table, and the probe presses against its side."""
    block = [*FLAT, 0.2, 0.0, HEIGHTS["block"] - SUNK]
    simulation.set_robot([0.2 - 0.045 - PROBE_RADIUS + 1e-4, 0.0], [0.0, 0.0])
    supports = _supports(simulation, block)
    simulation.set_robot([-0.7, 0.7], [0.0, 0.0])
    np.testing.assert_allclose(supports[0], UP, atol=1e-9)


def test_what_has_come_to_rest_is_supported(simulation):
    simulation.set_pose(FLAT, [0.0, 0.0, 2.0], 0)
    simulation.settle(CAN_UPRIGHT, [0.1, 0.2, HEIGHTS["soup"]], k=1)
    _, can = _found(simulation)
    np.testing.assert_allclose(can, UP, atol=1e-6)
