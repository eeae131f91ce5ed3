import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    Sphere,
)
import pytest

from pbpf_drake.shapes.contact_points import (
    REST_DEPTH,
    MakeContactPoints,
    MakeCore,
)

INSET = 1e-3


def _reach(points, direction) -> float:
    """How far the spheres extend along a unit vector."""
    return np.max(points.p_GS @ direction) + points.radius


def _unit_vectors(n: int, seed: int = 0) -> np.ndarray:
    v = np.random.default_rng(seed).standard_normal((n, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def _write_hull(folder, vertices: np.ndarray) -> str:
    """Writes an OBJ file: each vertex, and a surface that touches it."""
    file = folder / "hull.obj"
    n = len(vertices)
    lines = [f"v {x} {y} {z}" for x, y, z in vertices]
    lines += [
        f"f {i + 1} {(i + 1) % n + 1} {(i + 2) % n + 1}" for i in range(n)
    ]
    file.write_text("\n".join(lines))
    return str(file)


def test_a_box_has_a_sphere_around_each_corner():
    half = np.array([0.08, 0.1, 0.03])
    points = MakeContactPoints(Box(*(2 * half)))
    corners = np.sign(points.p_GS)
    assert len({tuple(c) for c in corners}) == len(points.p_GS) == 8
    np.testing.assert_allclose(points.p_GS, half * corners)
    assert points.radius == REST_DEPTH


def test_a_cylinder_has_spheres_around_both_rims():
    radius, length = 0.034, 0.1
    points = MakeContactPoints(Cylinder(radius, length))
    p = points.p_GS
    assert len(p) == 16
    np.testing.assert_allclose(np.hypot(p[:, 0], p[:, 1]), radius)
    np.testing.assert_allclose(np.abs(p[:, 2]), length / 2)
    assert points.radius == REST_DEPTH
    for end in -1, 1:
        rim = p[p[:, 2] * end > 0]
        angles = np.sort(np.arctan2(rim[:, 1], rim[:, 0]))
        np.testing.assert_allclose(np.diff(angles), np.pi / 4)


def test_the_points_of_a_capsule_are_its_ends():
    capsule = Capsule(0.02, 0.1)
    points = MakeContactPoints(capsule)
    assert points.radius == capsule.radius()
    for direction in _unit_vectors(50):
        expected = 0.05 * abs(direction[2]) + 0.02
        assert _reach(points, direction) == pytest.approx(expected)


@pytest.mark.parametrize("kind", [Convex, Mesh])
@pytest.mark.parametrize("n", [5, 9, 40])
def test_the_points_of_a_hull_are_vertices(tmp_path, kind, n):
    vertices = _unit_vectors(n, seed=n) * [0.05, 0.04, 0.02]
    points = MakeContactPoints(kind(_write_hull(tmp_path, vertices), 1.0))
    distances = np.linalg.norm(points.p_GS[:, None] - vertices, axis=2)
    touched = np.argmin(distances, axis=1)
    np.testing.assert_allclose(distances.min(axis=1), 0.0, atol=1e-12)
    assert len(set(touched)) == len(points.p_GS) == min(n, 16)
    if n <= 16:
        for direction in _unit_vectors(50):
            expected = np.max(vertices @ direction)
            reach = _reach(points, direction)
            assert abs(reach - expected) < 2 * points.radius


def test_points_of_a_hull_with_many_vertices_are_spread_over_it(tmp_path):
    vertices = _unit_vectors(300) * 0.05
    points = MakeContactPoints(Convex(_write_hull(tmp_path, vertices), 1.0))
    for direction in _unit_vectors(100, seed=1):
        # 16 points in the best spread are 0.86 rad from every direction.
        assert _reach(points, direction) > 0.05 * np.cos(1.0)


@pytest.mark.parametrize("shape", [Sphere(0.1), Ellipsoid(0.1, 0.2, 0.3)])
def test_what_is_round_all_over_has_no_points_and_no_core(shape):
    assert MakeContactPoints(shape).p_GS.shape == (0, 3)
    assert MakeCore(shape) is None


def test_a_core_is_smaller_by_the_inset_on_every_side():
    box = MakeCore(Box(0.1, 0.2, 0.3))
    np.testing.assert_allclose(
        box.size(), np.array([0.1, 0.2, 0.3]) - 2 * INSET
    )
    cylinder = MakeCore(Cylinder(0.03, 0.1))
    assert cylinder.radius() == pytest.approx(0.03 - INSET)
    assert cylinder.length() == pytest.approx(0.1 - 2 * INSET)


@pytest.mark.parametrize(
    "shape", [Box(0.1, 0.1, 0.001), Cylinder(0.03, 0.001), Capsule(0.1, 0.2)]
)
def test_what_is_too_thin_for_a_core_has_none(shape):
    assert MakeCore(shape) is None
