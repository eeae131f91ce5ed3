import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Box, Capsule, Cylinder, HalfSpace, Mesh, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder
import pytest
from scipy.optimize import linprog

from pbpf_drake.poses import quaternions
from pbpf_drake.shapes.bounding_boxes import MakeBoundingBoxes, least_distances

SHAPES = [Box(0.2, 0.1, 0.05), Cylinder(0.03, 0.1), Sphere(0.04)]
FRAMES = [
    RigidTransform([0.1, 0.0, 0.0]),
    RigidTransform(Quaternion([0.5, 0.5, -0.5, 0.5]), [0.0, -0.2, 0.1]),
    RigidTransform(),
]


def _world(*bodies):
    """Returns an inspector, and the geometries of the bodies."""
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, 0.0)
    geometries = []
    for b, shapes in enumerate(bodies):
        inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
        body = plant.AddRigidBody(f"body_{b}", inertia)
        geometries.append(
            [
                plant.RegisterCollisionGeometry(
                    body, X_BG, shape, f"{b}_{g}", CoulombFriction()
                )
                for g, (X_BG, shape) in enumerate(shapes)
            ]
        )
    return scene_graph.model_inspector(), geometries


def _random_poses(count: int, spread: float, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    q = quaternions.normalize(rng.standard_normal((count, 4)))
    p = rng.uniform(-spread, spread, (count, 3))
    return np.concatenate([q, p], axis=1)[:, None]


@pytest.fixture(scope="module")
def three():
    return MakeBoundingBoxes(
        *_world(
            list(zip(FRAMES, SHAPES, strict=True)), [(FRAMES[0], SHAPES[2])]
        )
    )


def test_boxes_are_as_large_as_the_shapes(three):
    np.testing.assert_array_equal(three.bodies, [0, 0, 0, 1])
    np.testing.assert_allclose(three.half_sizes[0], [0.1, 0.05, 0.025])
    np.testing.assert_allclose(three.half_sizes[1], [0.03, 0.03, 0.05])
    np.testing.assert_allclose(three.half_sizes[2], [0.04] * 3)
    np.testing.assert_allclose(three.centers[1], [0.0, -0.2, 0.1])


def test_corners_turn_with_the_body(three):
    turn = quaternions.from_rotation_vector(np.array([0.0, 0.0, np.pi / 2]))
    poses = np.array([[*turn, 1.0, 2.0, 3.0], [1, 0, 0, 0, 0, 0, 0]])
    corners = three.at(poses).corners()
    assert corners.shape == (4, 8, 3)
    # The box's long side, along x, is along y now.
    np.testing.assert_allclose(corners[0].max(axis=0), [1.05, 2.2, 3.025])
    np.testing.assert_allclose(corners[0].min(axis=0), [0.95, 2.0, 2.975])
    np.testing.assert_allclose(corners[3].max(axis=0), [0.14, 0.04, 0.04])


def test_radii_are_to_the_furthest_corner(three):
    far = np.linalg.norm([0.2, 0.05, 0.025])
    second = np.linalg.norm(
        three.at(_random_poses(1, 0, 0).repeat(2, 1)).corners()[0, 1], axis=-1
    )
    np.testing.assert_allclose(
        three.radii(2),
        [max(far, second.max()), np.linalg.norm([0.14, 0.04, 0.04])],
    )


def _distance(a: np.ndarray, b: np.ndarray) -> float:
    """Largest gap between the hulls of corners, along any of many axes."""
    axes = np.random.default_rng(0).standard_normal((4000, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    return np.max((b @ axes.T).min(axis=0) - (a @ axes.T).max(axis=0))


def _overlap(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether a point is a mean of the corners of both."""
    equations = np.vstack(
        [
            np.hstack([a.T, -b.T]),
            np.repeat([[1, 0], [0, 1]], 8, axis=1),
        ]
    )
    values = [0, 0, 0, 1, 1]
    result = linprog(np.zeros(16), A_eq=equations, b_eq=values)
    return result.status == 0


def test_boxes_are_at_least_as_far_apart_as_is_said():
    one = MakeBoundingBoxes(*_world([(FRAMES[2], SHAPES[0])]))
    two = MakeBoundingBoxes(*_world([(FRAMES[2], SHAPES[1])]))
    X_a, X_b = _random_poses(60, 0.15, 1), _random_poses(60, 0.15, 2)
    found = least_distances(one.at(X_a), two.at(X_b))[:, 0, 0]
    assert np.sum(found > 0.01) > 10 and np.sum(found < 0) > 10
    for distance, a, b in zip(
        found,
        one.at(X_a).corners()[:, 0],
        two.at(X_b).corners()[:, 0],
        strict=True,
    ):
        if distance > 0:
            assert not _overlap(a, b)
            # The gap along an axis is never more than the distance, which
            # is the largest gap of all.
            assert distance <= _distance(a, b) + 6e-3


def test_the_gap_between_faces_is_exact():
    boxes = MakeBoundingBoxes(*_world([(RigidTransform(), SHAPES[0])]))
    X_a = np.array([[1.0, 0, 0, 0, 0, 0, 0]])
    for gap in (-0.01, 0.0, 0.03):
        X_b = np.array([[1.0, 0, 0, 0, 0.2 + gap, 0.05, 0.0]])
        found = least_distances(boxes.at(X_a), boxes.at(X_b))
        np.testing.assert_allclose(found, [[gap]], atol=1e-12)


def test_a_shape_without_bounds_is_named():
    inspector, geometries = _world([(RigidTransform(), HalfSpace())])
    with pytest.raises(ValueError, match="0_0 has no bounds; expected"):
        MakeBoundingBoxes(inspector, geometries)


def test_round_and_users_shapes_have_boxes(tmp_path):
    file = tmp_path / "tetrahedron.obj"
    file.write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
        "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    shapes = [Capsule(0.1, 0.3), Mesh(str(file), 0.1)]
    boxes = MakeBoundingBoxes(*_world([(RigidTransform(), s) for s in shapes]))
    np.testing.assert_allclose(boxes.half_sizes[0], [0.1, 0.1, 0.25])
    corners = boxes.at(np.array([[1.0, 0, 0, 0, 0, 0, 0]])).corners()[1]
    vertices = 0.1 * np.vstack([np.zeros(3), np.eye(3)])
    for vertex in vertices:
        assert not np.any(_outside(vertex, corners))


def _outside(point: np.ndarray, corners: np.ndarray) -> np.ndarray:
    centre = corners.mean(axis=0)
    axes = [corners[1] - corners[0], corners[2] - corners[0]]
    axes.append(corners[4] - corners[0])
    return np.array(
        [abs((point - centre) @ axis) > axis @ axis / 2 + 1e-6 for axis in axes]
    )
