import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    MeshcatCone,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction
from pydrake.planning import RobotDiagramBuilder
import pytest

from pbpf_drake.shapes.signed_distance import MakeSignedDistance

CORNERS = np.random.default_rng(5).uniform(-0.3, 0.3, (12, 3))
SHAPES = {
    "box": Box(0.2, 0.4, 0.6),
    "sphere": Sphere(0.3),
    "cylinder": Cylinder(0.2, 0.5),
    "capsule": Capsule(0.15, 0.5),
    "half space": HalfSpace(),
    "ellipsoid": Ellipsoid(0.1, 0.2, 0.4),
    "hull": Convex(CORNERS.T, "corners"),
}
EXACT = ("box", "sphere", "cylinder", "capsule", "half space")


def _points(num=300):
    return np.random.default_rng(0).uniform(-0.5, 0.5, (num, 3))


def _from_drake(shape, points):
    """Returns distances and gradients that Drake calculates, one by one."""
    builder = RobotDiagramBuilder(time_step=0.0)
    plant = builder.plant()
    plant.RegisterCollisionGeometry(
        plant.world_body(),
        RigidTransform(),
        shape,
        "shape",
        CoulombFriction(),
    )
    plant.Finalize()
    diagram = builder.Build()
    query = (
        diagram.scene_graph()
        .get_query_output_port()
        .Eval(diagram.scene_graph_context(diagram.CreateDefaultContext()))
    )
    found = [query.ComputeSignedDistanceToPoint(p)[0] for p in points]
    return (
        np.array([f.distance for f in found]),
        np.array([f.grad_W for f in found]),
    )


@pytest.mark.parametrize("name", EXACT)
def test_distances_and_normals_are_those_of_drake(name):
    points = _points()
    distances, normals = MakeSignedDistance(SHAPES[name])(points)
    expected, gradients = _from_drake(SHAPES[name], points)
    np.testing.assert_allclose(distances, expected, atol=1e-12)
    np.testing.assert_allclose(normals, gradients, atol=1e-9)


@pytest.mark.parametrize("name", SHAPES)
def test_what_lies_on_the_surface_has_no_distance(name):
    """A small way along the normal from there is the distance."""
    distance = MakeSignedDistance(SHAPES[name])
    points = _points()
    if name == "ellipsoid":
        points *= 0.1 / np.linalg.norm(points / [1, 2, 4], axis=1)[:, None]
    elif name == "hull":
        # Middles of faces: three corners that all others are on one side of.
        hull = SHAPES[name].GetConvexHull()
        points = np.array(
            [
                np.mean(
                    [
                        hull.vertex(hull.element(f).vertex(i))
                        for i in range(hull.element(f).num_vertices())
                    ],
                    axis=0,
                )
                for f in range(hull.num_faces())
            ]
        )
    else:
        d, n = distance(points)
        points = points - d[:, None] * n
    d, n = distance(points)
    np.testing.assert_allclose(d, 0.0, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(n, axis=1), 1.0)
    d, _ = distance(points + 1e-4 * n)
    np.testing.assert_allclose(d, 1e-4, atol=3e-6)


def test_the_normal_is_the_slope_of_the_distance():
    rng = np.random.default_rng(1)
    for name in ("ellipsoid", "hull"):
        distance = MakeSignedDistance(SHAPES[name])
        points = _points(50) if name == "hull" else _points(50) * 0.01 + 0.09
        step = 1e-7 * rng.standard_normal(3)
        d, n = distance(points)
        after, _ = distance(points + step)
        np.testing.assert_allclose(after - d, n @ step, atol=5e-8)


@pytest.mark.filterwarnings("error")
def test_there_is_a_number_even_where_no_direction_is_nearest():
    for shape in SHAPES.values():
        d, n = MakeSignedDistance(shape)(np.zeros((1, 3)))
        assert np.isfinite(d).all() and np.isfinite(n).all()
        d, _ = MakeSignedDistance(shape)(np.full((1, 3), np.nan))
        assert not d > 0 and not d < 0


def test_a_shape_without_a_volume_is_refused():
    with pytest.raises(ValueError, match="expected a Box"):
        MakeSignedDistance(MeshcatCone(1.0, 0.5, 0.5))
