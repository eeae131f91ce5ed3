from hull_fixtures import write_hull
import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryInstance,
    HalfSpace,
    Mesh,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
import pytest
from scipy.integrate import dblquad
from scipy.spatial import ConvexHull

from pbpf_drake.shapes.surface_sampling import BodySurface, MakeSurface

CORNERS = np.random.default_rng(5).uniform(-0.3, 0.3, (12, 3))
SHAPES = {
    "box": Box(0.1, 0.2, 0.4),
    "sphere": Sphere(0.3),
    "ellipsoid": Ellipsoid(0.1, 0.2, 0.5),
    "cylinder": Cylinder(0.2, 0.3),
    "capsule": Capsule(0.15, 0.5),
    "convex": Convex(CORNERS.T, "corners"),
}
RADII = np.array([0.1, 0.2, 0.5])


def _ellipsoid_integral(function):
    """Integrates function(p) over the ellipsoid's surface by quadrature."""

    def integrand(angle, z):
        n = np.array([np.cos(angle), np.sin(angle), 0]) * np.sqrt(1 - z * z)
        n[2] = z
        stretch = np.prod(RADII) * np.linalg.norm(n / RADII)
        return function(n * RADII) * stretch

    # The eighth with all coordinates positive.
    return 8 * dblquad(integrand, 0, 1, 0, np.pi / 2, epsabs=1e-9)[0]


def _surface_centroid(corners):
    triangles = corners[ConvexHull(corners).simplices]
    a, b, c = np.moveaxis(triangles, 1, 0)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=-1)
    return areas @ triangles.mean(axis=1) / areas.sum()


AREAS = {
    "box": 2 * (0.1 * 0.2 + 0.1 * 0.4 + 0.2 * 0.4),
    "sphere": 4 * np.pi * 0.3**2,
    "ellipsoid": _ellipsoid_integral(lambda p: 1.0),
    "cylinder": 2 * np.pi * 0.2 * (0.2 + 0.3),
    "capsule": 2 * np.pi * 0.15 * 0.5 + 4 * np.pi * 0.15**2,
    "convex": ConvexHull(CORNERS).area,
}


@pytest.mark.parametrize("name", SHAPES)
def test_areas_are_exact(name):
    np.testing.assert_allclose(MakeSurface(SHAPES[name]).area, AREAS[name])


@pytest.mark.parametrize("name", SHAPES)
def test_points_lie_on_the_surface_where_drake_has_it(name):
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource("test")
    instance = GeometryInstance(RigidTransform(), SHAPES[name], "shape")
    instance.set_proximity_properties(ProximityProperties())
    scene_graph.RegisterAnchoredGeometry(source, instance)
    context = scene_graph.CreateDefaultContext()
    query_object = scene_graph.get_query_output_port().Eval(context)
    points = MakeSurface(SHAPES[name]).sample(np.random.default_rng(0), 100)
    # Drake finds its distance from an ellipsoid by iterating.
    tolerance = 1e-4 if name == "ellipsoid" else 1e-9
    assert points.shape == (100, 3)
    for p in points:
        (found,) = query_object.ComputeSignedDistanceToPoint(p)
        assert abs(found.distance) < tolerance


# What share of the surface is where, and functions with known means over it.
MEANS = {
    "box": [
        (lambda p: np.isclose(p[:, 0], 0.05), 0.08 / 0.28),
        (lambda p: np.isclose(p[:, 1], -0.1), 0.04 / 0.28),
        (lambda p: np.isclose(p[:, 2], 0.2), 0.02 / 0.28),
        (lambda p: (p[:, 2] > 0.1) & (p[:, 1] > 0), 0.5 * (0.02 + 0.06) / 0.28),
    ],
    "sphere": [
        (lambda p: p[:, 2] > 0.15, 0.25),
        (lambda p: p @ [0.6, 0, 0.8] > 0.15, 0.25),
        (lambda p: (p[:, 0] > 0) & (p[:, 1] > 0), 0.25),
    ],
    "ellipsoid": [
        (
            lambda p, i=i: p[:, i] ** 2 / RADII[i] ** 2,
            _ellipsoid_integral(lambda p, i=i: p[i] ** 2 / RADII[i] ** 2)
            / AREAS["ellipsoid"],
        )
        for i in range(3)
    ],
    "cylinder": [
        (lambda p: np.isclose(p[:, 2], 0.15), 0.2),
        (lambda p: np.isclose(p[:, 2], -0.15), 0.2),
        (lambda p: p[:, 2] > 0.075, 0.2 + 0.6 / 4),
        (lambda p: np.hypot(p[:, 0], p[:, 1]) < 0.1, 2 * 0.2 / 4),
        (lambda p: (p[:, 0] > 0) & (p[:, 1] < 0), 0.25),
    ],
    "capsule": [
        (lambda p: np.abs(p[:, 2]) < 0.25, 0.5 / 0.8),
        (lambda p: p[:, 2] > 0.325, 0.075 / 0.8),
        (lambda p: (p[:, 0] > 0) & (p[:, 1] < 0), 0.25),
    ],
    "convex": [
        (
            lambda p, f=f: np.abs(p @ f[:3] + f[3]) < 1e-9,
            ConvexHull(
                (CORNERS @ np.linalg.svd(f[None, :3])[2][1:].T)[
                    np.abs(CORNERS @ f[:3] + f[3]) < 1e-9
                ]
            ).volume
            / AREAS["convex"],
        )
        for f in ConvexHull(CORNERS).equations
    ]
    + [
        (lambda p, i=i: p[:, i], mean)
        for i, mean in enumerate(_surface_centroid(CORNERS))
    ],
}


@pytest.mark.parametrize("name", SHAPES)
def test_each_point_is_uniform_over_the_area(name):
    surface = MakeSurface(SHAPES[name])
    rng = np.random.default_rng(0)
    # One point of each draw, as the lattice makes the errors of all cancel.
    points = np.stack([surface.sample(rng, 3)[2] for _ in range(5000)])
    for function, mean in MEANS[name]:
        values = function(points).astype(float)
        error = np.std(values) / np.sqrt(len(values))
        assert abs(np.mean(values) - mean) < 4 * error


@pytest.mark.parametrize("name", SHAPES)
def test_a_mean_over_one_draw_scatters_less_than_over_independent_points(name):
    surface = MakeSurface(SHAPES[name])
    rng = np.random.default_rng(1)
    direction = np.array([0.3, -0.5, 0.8])
    shares = [
        np.mean(surface.sample(rng, 48) @ direction > 0) for _ in range(400)
    ]
    share = np.mean(shares)
    assert np.std(shares) < 0.75 * np.sqrt(share * (1 - share) / 48)


def test_the_shapes_of_a_body_share_its_points_by_area():
    rng = np.random.default_rng(2)
    X_BG = [
        RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [5, 0, 0]),
        RigidTransform(RollPitchYaw(1, 2, 3), [-5, 1, 2]),
    ]
    body = BodySurface(shapes=[Sphere(0.1), Cylinder(0.2, 0.3)], X_BG=X_BG)
    sphere, cylinder = 4 * np.pi * 0.01, 0.2 * np.pi
    np.testing.assert_allclose(body.area, sphere + cylinder)
    points = body.sample(rng, 500)
    on_sphere = points[:, 0] > 0
    share = 500 * sphere / (sphere + cylinder)
    assert abs(np.count_nonzero(on_sphere) - share) <= 1
    p_sphere = X_BG[0].inverse() @ points[on_sphere].T
    np.testing.assert_allclose(np.linalg.norm(p_sphere, axis=0), 0.1)
    x, y, z = X_BG[1].inverse() @ points[~on_sphere].T
    on_side = np.isclose(np.hypot(x, y), 0.2) & (np.abs(z) <= 0.15)
    on_ends = np.isclose(np.abs(z), 0.15) & (np.hypot(x, y) <= 0.2)
    assert np.all(on_side | on_ends)


def test_few_points_of_a_body_still_reach_all_of_its_shapes():
    X_BG = [RigidTransform([5, 0, 0]), RigidTransform([-5, 0, 0])]
    body = BodySurface(shapes=[Sphere(0.1), Sphere(0.2)], X_BG=X_BG)
    rng = np.random.default_rng(3)
    share = np.mean([body.sample(rng, 1)[0, 0] > 0 for _ in range(3000)])
    assert abs(share - 0.2) < 4 * np.sqrt(0.2 * 0.8 / 3000)


@pytest.mark.parametrize("name", SHAPES)
def test_points_are_a_function_of_the_generators_state(name):
    body = BodySurface(shapes=[SHAPES[name]], X_BG=[RigidTransform()])
    first = body.sample(np.random.default_rng(7), 20)
    again = body.sample(np.random.default_rng(7), 20)
    other = body.sample(np.random.default_rng(8), 20)
    np.testing.assert_array_equal(first, again)
    assert not np.allclose(first, other)


def test_a_mesh_is_sampled_on_its_scaled_convex_hull(tmp_path):
    path = tmp_path / "hull.obj"
    write_hull(path, CORNERS)
    mesh = MakeSurface(Mesh(str(path), 2.0))
    np.testing.assert_allclose(mesh.area, 4 * AREAS["convex"])


def test_a_half_space_is_refused():
    with pytest.raises(ValueError, match="HalfSpace.*finite area"):
        BodySurface(shapes=[HalfSpace()], X_BG=[RigidTransform()])
