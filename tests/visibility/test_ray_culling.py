import numpy as np
from pydrake.geometry import Box, Sphere
from pydrake.math import RollPitchYaw
import pytest

from pbpf_drake.visibility.ray_culling import (
    coordinates,
    may_enter_box,
    may_hit_ball,
    may_hit_balls,
)
from pbpf_drake.visibility.ray_shapes import MakeRayShape


def test_a_ball_that_any_ray_of_a_group_meets_is_near_the_group():
    rng = np.random.default_rng(6)
    ways = rng.normal(size=(60, 1, 3)) + rng.normal(size=(60, 30, 3)) * 0.1
    p_OG = rng.normal(size=(50, 1, 3))
    radii = rng.uniform(0.01, 0.3, (50, 1))
    near = may_hit_balls(coordinates(ways), p_OG, radii)
    on_the_way = np.array(
        [
            (MakeRayShape(Sphere(r)).intersect(-p, ways) <= 1).any(axis=1)
            for (p,), (r,) in zip(p_OG, radii, strict=True)
        ]
    )
    assert np.all(near[on_the_way])
    assert on_the_way.any()
    assert near.mean() < 0.1
    assert may_hit_balls(
        coordinates(ways), p_OG, np.full((50, 1), np.inf)
    ).all()


def test_a_ray_that_hits_a_ball_is_near_it():
    rng = np.random.default_rng(2)
    d = rng.normal(size=(500, 3))
    radii = rng.uniform(0, 0.9, 40)
    for p, r in zip(rng.normal(size=(40, 3)), radii, strict=True):
        hits = np.isfinite(MakeRayShape(Sphere(r)).intersect(-p, d))
        near = may_hit_ball(coordinates(d), p, r)
        np.testing.assert_array_equal(near, hits)
    assert may_hit_ball(coordinates(d), np.ones(3), np.inf).all()


@pytest.mark.parametrize("inside", [False, True])
def test_a_ray_that_hits_a_box_before_its_end_may_enter_box_its_side(inside):
    rng = np.random.default_rng(3)
    ray_box = MakeRayShape(Box(0.4, 0.6, 0.2))
    num_left_out = 0
    for _ in range(40):
        d = rng.normal(size=(200, 3))
        R_WG = RollPitchYaw(rng.uniform(-3, 3, 3)).ToRotationMatrix().matrix()
        o = rng.uniform(-1, 1, 3) * (0.1 if inside else 1.0)
        behind = may_enter_box(coordinates(d), o, R_WG, ray_box.bounds)
        assert behind[ray_box.intersect(o, d @ R_WG) <= 1].all()
        num_left_out += np.count_nonzero(~behind)
    assert (num_left_out == 0) if inside else (num_left_out > 4000)
