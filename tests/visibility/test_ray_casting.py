import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
import pytest
from sphere_tracing import trace

from pbpf_drake.poses import quaternions
from pbpf_drake.visibility.ray_casting import CastRays, OccluderSet, RayBody
from pbpf_drake.visibility.ray_shapes import MakeRayShape

SHAPES = [
    Box(0.3, 0.2, 0.5),
    Box(1.5, 0.02, 1.0),
    Cylinder(0.1, 0.6),
    Cylinder(0.4, 0.05),
    Sphere(0.2),
    Capsule(0.05, 0.5),
    Ellipsoid(0.1, 0.2, 0.3),
]


def _random_pose(rng, scale):
    return RigidTransform(
        RollPitchYaw(rng.uniform(-3, 3, 3)), rng.uniform(-scale, scale, 3)
    )


class _World:
    """Anchored shapes in a SceneGraph."""

    def __init__(self, shapes, poses):
        self.scene_graph = SceneGraph()
        source = self.scene_graph.RegisterSource("test")
        self.ids = []
        for i, (shape, X_WG) in enumerate(zip(shapes, poses, strict=True)):
            instance = GeometryInstance(X_WG, shape, f"shape_{i}")
            instance.set_proximity_properties(ProximityProperties())
            self.ids.append(
                self.scene_graph.RegisterAnchoredGeometry(source, instance)
            )
        self.context = self.scene_graph.CreateDefaultContext()

    def query_object(self):
        return self.scene_graph.get_query_output_port().Eval(self.context)


@pytest.mark.parametrize("seed", range(3))
def test_first_hits_agree_with_sphere_tracing(seed):
    rng = np.random.default_rng(seed)
    poses = [_random_pose(rng, 0.8) for _ in SHAPES]
    floor = RigidTransform([0, 0, -0.9])
    world = _World([*SHAPES, HalfSpace()], [*poses, floor])
    origin = np.array([1.6, 0.3, 1.2])
    targets = rng.uniform(-1.2, 1.2, (150, 3))
    t = CastRays(
        query_object=world.query_object(),
        geometry_ids=world.ids,
        origin=origin,
        targets=targets,
    )
    expected = [trace(world.query_object(), origin, p)[0] for p in targets]
    assert 25 < np.count_nonzero(np.isfinite(t)) < 125
    np.testing.assert_allclose(t, expected, atol=1e-6)


def test_what_is_beyond_the_target_or_behind_the_origin_is_not_hit():
    X_WG = RigidTransform([0, 0, 2])
    world = _World([Sphere(0.5)], [X_WG])
    occluders = OccluderSet(
        inspector=world.scene_graph.model_inspector(), geometry_ids=world.ids
    )
    targets = np.array([[0, 0, 1.49], [0, 0, 1.51], [0, 0, 6], [0, 0, -2]])
    t = occluders.Cast(
        query_object=world.query_object(),
        origin=np.zeros(3),
        targets=targets,
    )
    np.testing.assert_allclose(t, [np.inf, 1.5 / 1.51, 0.25, np.inf])


def test_an_origin_inside_a_geometry_hits_it_at_zero():
    world = _World([Box(1, 1, 1)], [RigidTransform([0.3, 0, 0])])
    t = CastRays(
        query_object=world.query_object(),
        geometry_ids=world.ids,
        origin=np.zeros(3),
        targets=np.array([[5.0, 0, 0], [0, 0, 0]]),
    )
    np.testing.assert_array_equal(t, 0)


def test_only_the_named_geometries_are_hit():
    poses = [RigidTransform([x, 0, 0]) for x in (1.0, 2.0)]
    world = _World([Sphere(0.1), Sphere(0.1)], poses)
    for ids, expected in (
        (world.ids, 0.3),
        (world.ids[1:], 1.9 / 3),
        ([], np.inf),
    ):
        t = CastRays(
            query_object=world.query_object(),
            geometry_ids=ids,
            origin=np.zeros(3),
            targets=np.array([3.0, 0, 0]),
        )
        np.testing.assert_allclose(t, expected)


def test_targets_keep_their_shape():
    world = _World([Sphere(0.5)], [RigidTransform([0, 0, 2])])
    targets = np.random.default_rng(0).normal(size=(2, 3, 5, 3))
    cast = {
        "query_object": world.query_object(),
        "geometry_ids": world.ids,
        "origin": np.zeros(3),
    }
    t = CastRays(**cast, targets=targets)
    assert t.shape == (2, 3, 5)
    one_by_one = [CastRays(**cast, targets=p) for p in targets.reshape(-1, 3)]
    np.testing.assert_array_equal(t.ravel(), one_by_one)


def test_it_makes_no_difference_which_targets_are_together():
    rng = np.random.default_rng(4)
    poses = [_random_pose(rng, 0.8) for _ in SHAPES]
    floor = RigidTransform([0, 0, -0.9])
    world = _World([*SHAPES, HalfSpace()], [*poses, floor])
    middles = rng.uniform(-1.2, 1.2, (40, 1, 3))
    targets = middles + rng.uniform(-0.1, 0.1, (40, 25, 3))
    # Some of them on the floor, where they are just reached or just not.
    targets[:10, :, 2] = -0.9 + rng.choice([1e-9, -1e-9, 1e-5], (10, 25))
    occluders = OccluderSet(
        inspector=world.scene_graph.model_inspector(), geometry_ids=world.ids
    )
    cast = {
        "query_object": world.query_object(),
        "origin": np.array([1.6, 0.3, 1.2]),
    }
    t = occluders.Cast(**cast, targets=targets)
    alone = [occluders.Cast(**cast, targets=p) for p in targets.reshape(-1, 3)]
    np.testing.assert_array_equal(t.ravel(), alone)
    # And without leaving any out: each shape meets every ray.
    d = targets - cast["origin"]
    all_hits = []
    for id, shape in zip(world.ids, [*SHAPES, HalfSpace()], strict=True):
        X_WG = world.query_object().GetPoseInWorld(id)
        R, o = X_WG.rotation().matrix(), X_WG.inverse() @ cast["origin"]
        all_hits.append(MakeRayShape(shape).intersect(o, d @ R))
    first = np.min(all_hits, axis=0)
    sure = np.abs(first - 1) > 1e-9
    expected = np.where(first <= 1, first, np.inf)
    np.testing.assert_allclose(t[sure], expected[sure], rtol=1e-9)
    assert 100 < np.count_nonzero(np.isfinite(t)) < 900


def test_a_body_is_within_its_bounding_ball():
    rng = np.random.default_rng(7)
    X_BG = [_random_pose(rng, 0.3) for _ in SHAPES]
    body = RayBody(shapes=SHAPES, X_BG=X_BG)
    pose = np.array([[1.0, 0, 0, 0, 0, 0, 0]])
    outward = rng.normal(size=(1, 5000, 3))
    outward /= np.linalg.norm(outward, axis=-1, keepdims=True)
    for n in outward[0, :50]:
        origin = 3 * n
        side = np.cross(n, rng.normal(size=3))
        beside = side / np.linalg.norm(side) * body.bounding_radius * 1.001
        targets = (origin + beside - 6 * n)[None, None]
        t = body.Cast(poses=pose, origin=origin + beside, targets=targets)
        assert np.isinf(t).all()
    assert body.bounding_radius < 1.2


def test_bodies_of_particles_are_hit_where_the_scene_graph_has_them():
    rng = np.random.default_rng(3)
    shapes, X_BG = SHAPES[:3], [_random_pose(rng, 0.3) for _ in range(3)]
    q = quaternions.normalize(rng.normal(size=(6, 4)))
    poses = np.hstack([q, rng.uniform(-0.3, 0.3, (6, 3)), np.full((6, 2), 9.0)])
    targets = rng.uniform(-1, 1, (6, 4, 10, 3))
    origin = np.array([1.5, 0.2, 0.9])
    t = RayBody(shapes=shapes, X_BG=X_BG).Cast(
        poses=poses, origin=origin, targets=targets
    )
    t[t > 1] = np.inf
    for m in range(6):
        X_WB = RigidTransform(quaternion=Quaternion(wxyz=q[m]), p=poses[m, 4:7])
        world = _World(shapes, [X_WB @ X for X in X_BG])
        expected = CastRays(
            query_object=world.query_object(),
            geometry_ids=world.ids,
            origin=origin,
            targets=targets[m],
        )
        np.testing.assert_allclose(t[m], expected, atol=1e-12)
    assert 20 < np.count_nonzero(np.isfinite(t)) < 200
