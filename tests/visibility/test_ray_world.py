import numpy as np
import pytest
from visibility_fixtures import AHEAD, BOX, SMALL, WALL, camera_scene

from pbpf_drake.visibility.ray_world import RayWorld


def _seen(world, p_OT, *, q=0.0, context=None):
    """Returns the share of points of one particle's object that is seen."""
    share = world.CalcSeenShares(
        np.array([[AHEAD]], dtype=float),
        tracked=np.array([0]),
        p_OT=np.array([p_OT], dtype=float),
        robot_positions=np.array([q]),
        context=context or world.MakeContext(),
    )
    assert share.shape == (1, 1)
    return share.item()


def test_the_share_is_that_of_the_points_that_nothing_hides(tmp_path):
    scene = camera_scene(tmp_path, objects={"thing": BOX}, fixed=[WALL])
    # The wall hides what is at x > 0.
    world, left, right = RayWorld(scene), [-0.05, 0, 0], [0.05, 0, 0]
    assert _seen(world, [left]) == 1.0
    assert _seen(world, [right]) == 0.0
    assert _seen(world, [left, left, left, right]) == 0.75


def test_a_point_on_the_back_counts_as_seen(tmp_path):
    world = RayWorld(camera_scene(tmp_path, objects={"thing": BOX}))
    assert _seen(world, [[0.0, 0.0, 0.15]]) == 1.0


def test_what_was_in_the_context_makes_no_difference(tmp_path):
    world = RayWorld(camera_scene(tmp_path, objects={"thing": SMALL}))
    context = world.MakeContext()
    # At 1.6 the robot is before the object.
    found = [
        _seen(world, [[0, 0, 0]], q=q, context=context) for q in (0, 1.6, 0)
    ]
    assert found == [1.0, 0.0, 1.0]


def test_each_object_has_its_own_surface(tmp_path):
    scene = camera_scene(tmp_path, objects={"thing": BOX, "small": SMALL})
    areas = [surface.area for surface in RayWorld(scene).surfaces()]
    np.testing.assert_allclose(areas, [2 * (0.02 + 0.03 + 0.06), 6 * 0.04**2])


def test_an_object_without_collision_geometry_is_refused(tmp_path):
    scene = camera_scene(tmp_path, objects={"ghost": ""})
    with pytest.raises(ValueError, match="'ghost' has no collision geometry"):
        RayWorld(scene)


def test_a_camera_inside_a_fixed_model_is_refused(tmp_path):
    scene = camera_scene(
        tmp_path, objects={"thing": BOX}, fixed=[WALL, (BOX, (0, 0.01, 0))]
    )
    with pytest.raises(ValueError, match="camera.X_WC is inside .*fixed_1"):
        RayWorld(scene)
