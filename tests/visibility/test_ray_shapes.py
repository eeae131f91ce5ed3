from hull_fixtures import write_hull
import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    MeshcatCone,
    Sphere,
)
import pytest
from scipy.spatial import ConvexHull

from pbpf_drake.visibility.ray_shapes import MakeRayShape

CORNERS = np.random.default_rng(5).uniform(-0.3, 0.3, (12, 3))


def _segment_distance(p):
    z = np.clip(p[..., 2], -0.25, 0.25)
    return np.linalg.norm(p - z[..., None] * [0, 0, 1], axis=-1)


def _hull_level(p, corners=CORNERS):
    planes = ConvexHull(corners).equations
    return np.max(p @ planes[:, :3].T + planes[:, 3], axis=-1)


# A shape, and a function that is negative inside, zero on the surface.
SHAPES = {
    "box": (
        Box(0.2, 0.4, 0.6),
        lambda p: np.max(np.abs(p) - [0.1, 0.2, 0.3], axis=-1),
    ),
    "sphere": (Sphere(0.3), lambda p: np.linalg.norm(p, axis=-1) - 0.3),
    "ellipsoid": (
        Ellipsoid(0.1, 0.2, 0.4),
        lambda p: np.linalg.norm(p / [0.1, 0.2, 0.4], axis=-1) - 1,
    ),
    "cylinder": (
        Cylinder(0.2, 0.5),
        lambda p: np.maximum(
            np.hypot(p[..., 0], p[..., 1]) - 0.2, np.abs(p[..., 2]) - 0.25
        ),
    ),
    "capsule": (Capsule(0.15, 0.5), lambda p: _segment_distance(p) - 0.15),
    "half space": (HalfSpace(), lambda p: p[..., 2]),
    "convex": (Convex(CORNERS.T, "corners"), _hull_level),
}


def _rays(num=400):
    """Rays from far and near, some from inside, of very different lengths."""
    rng = np.random.default_rng(0)
    o = rng.normal(size=(num, 3)) * rng.uniform(0.05, 1, (num, 1))
    target = rng.uniform(-0.3, 0.3, (num, 3))
    return o, (target - o) * rng.uniform(0.2, 2, (num, 1))


@pytest.mark.parametrize("name", SHAPES)
def test_entry_is_the_first_point_of_the_ray_in_the_solid(name):
    shape, level = SHAPES[name]
    o, d = _rays()
    t = MakeRayShape(shape).intersect(o, d)
    inside = level(o) < 0
    hit = np.isfinite(t)
    assert inside.sum() > 10 and (hit & ~inside).sum() > 50
    np.testing.assert_array_equal(t[inside], 0)
    entered = hit & ~inside
    on_surface = level(o + np.where(hit, t, 0)[:, None] * d)[entered]
    np.testing.assert_allclose(on_surface, 0, atol=1e-12)
    # No sample of the ray is inside before its entry, or at all if it misses.
    before = (
        np.linspace(0, 1, 2000, endpoint=False) * np.minimum(t, 20)[:, None]
    )
    p = o[:, None] + before[..., None] * d[:, None]
    assert np.all(level(p)[~inside] > -1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_rays_along_the_axes_from_the_axes_meet_no_division_by_zero(name):
    shape, level = SHAPES[name]
    for axis in range(3):
        d = -np.eye(3)[axis]
        t = MakeRayShape(shape).intersect(-2 * d, d)
        if np.isfinite(t):
            assert abs(level(-2 * d + t * d)) < 1e-12
        beside = np.roll(d, 1) * 5 - 2 * d
        t_beside = MakeRayShape(shape).intersect(beside, d)
        samples = beside + np.linspace(0, 20, 5000)[:, None] * d
        assert np.isfinite(t_beside) == np.any(level(samples) <= 0)


@pytest.mark.parametrize("name", SHAPES)
def test_a_ray_of_no_length_hits_what_it_is_in(name):
    shape, level = SHAPES[name]
    o, _ = _rays()
    t = MakeRayShape(shape).intersect(o, np.zeros(3))
    np.testing.assert_array_equal(t == 0, level(o) < 0)
    assert np.all((t == 0) | (t > 1))


@pytest.mark.parametrize("name", SHAPES)
def test_origins_and_directions_broadcast(name):
    ray_shape = MakeRayShape(SHAPES[name][0])
    o, d = _rays(12)
    t = ray_shape.intersect(o[:3, None], d[None])
    assert t.shape == (3, 12)
    for i in range(3):
        for j in range(12):
            one = ray_shape.intersect(o[i], d[j])
            np.testing.assert_allclose(t[i, j], one, rtol=1e-12)


@pytest.mark.parametrize("name", SHAPES)
def test_the_bounding_ball_contains_the_shape_and_no_more_than_it_must(name):
    shape, level = SHAPES[name]
    radius = MakeRayShape(shape).bounding_radius
    if name == "half space":
        assert radius == np.inf
        return
    directions = np.random.default_rng(1).normal(size=(20000, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    assert np.all(level(directions * radius * (1 + 1e-12)) >= 0)
    assert np.any(level(directions * radius * 0.98) < 0)


@pytest.mark.parametrize("name", SHAPES)
def test_the_bounds_contain_the_shape_and_no_more_than_they_must(name):
    shape, level = SHAPES[name]
    low, high = MakeRayShape(shape).bounds
    p = np.random.default_rng(1).uniform(-0.5, 0.5, (200_000, 3))
    inside = p[level(p) <= 0]
    assert np.all((inside >= low) & (inside <= high))
    reached = np.clip([low, high], -0.5, 0.5)
    found = [inside.min(axis=0), inside.max(axis=0)]
    np.testing.assert_allclose(found, reached, atol=0.03)


def test_a_mesh_is_its_scaled_convex_hull(tmp_path):
    path = tmp_path / "hull.obj"
    write_hull(path, CORNERS)
    o, d = _rays()
    expected = MakeRayShape(Convex(2 * CORNERS.T, "corners")).intersect(o, d)
    for shape in (Mesh(str(path), 2.0), Convex(str(path), 2.0)):
        t = MakeRayShape(shape).intersect(o, d)
        np.testing.assert_allclose(t, expected, rtol=1e-9)


def test_a_shape_without_volume_is_refused_by_name():
    with pytest.raises(ValueError, match="MeshcatCone.*expected a Box"):
        MakeRayShape(MeshcatCone(1, 1, 1))
