"""The scene files against their models, the recordings and their camera."""

from model_world import World, load_scene
import numpy as np
from pydrake.multibody.plant import (
    CalcContactFrictionFromSurfaceProperties,
    CoulombFriction,
)
from pydrake.multibody.tree import RigidBody
import pytest

from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.shapes.box_corners import box_corners

SCENES = ["cheezit_1", "planar_push"]


def _half_size(world: World, body: RigidBody) -> np.ndarray:
    (geometry,) = world.shape_ids(body)
    return world.scene_graph.model_inspector().GetShape(geometry).size() / 2


def _corners(world: World, body: RigidBody, shift=(0, 0, 0)) -> np.ndarray:
    """The eight corners of a body's box (8, 3), in the world."""
    X_WB = body.EvalPoseInWorld(world.context)
    return (X_WB @ box_corners(_half_size(world, body)).T).T + shift


def _is_in_image(camera: CameraConfig, p_W: np.ndarray) -> np.ndarray:
    x, y, z = camera.pose().inverse() @ p_W.T
    u = camera.fx * x / z + camera.cx
    v = camera.fy * y / z + camera.cy
    inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    return (z > 0) & inside


@pytest.mark.parametrize("name", SCENES)
def test_object_and_obstacle_rest_on_the_table(name):
    world, _, body = load_scene(name)
    resting = [body] + [b for b in world.bodies() if "obstacle" in b.name()]
    assert len(resting) == {"cheezit_1": 2, "planar_push": 1}[name]
    for body in resting:
        assert abs(_corners(world, body)[:, 2].min()) < 1e-9, body.name()
    deepest = world.query().ComputePointPairPenetration()
    assert all(pair.depth < 1e-9 for pair in deepest)


@pytest.mark.parametrize(
    "name, push",
    # The recorded runs end with the block between x = 0.45 and x = 0.59.
    [("cheezit_1", [0, 0.45, 0]), ("planar_push", [0.39, 0, 0])],
)
def test_camera_has_the_object_in_its_image_all_the_way(name, push):
    world, camera, body = load_scene(name)
    for part in np.linspace(0, 1, 10):
        corners = _corners(world, body, shift=part * np.array(push))
        assert _is_in_image(camera, corners).all()


def _is_blocked(world: World, camera: CameraConfig, p_W: np.ndarray) -> bool:
    """Whether the obstacle is on the straight line to the camera."""
    obstacle = world.plant.GetBodyByName("scene_1_obstacle")
    p_WC = camera.pose().translation()
    length = np.linalg.norm(p_W - p_WC)
    travelled = 0.0
    while travelled < length:  # Sphere tracing.
        point = p_WC + travelled / length * (p_W - p_WC)
        distance = world.distance(obstacle, point)
        if distance < 1e-4:
            return True
        travelled += distance
    return False


def test_obstacle_hides_the_cracker_at_the_end_of_the_push_only():
    world, camera, body = load_scene("cheezit_1")
    corners = _corners(world, body)
    x, y, z = np.linspace(corners.min(axis=0), corners.max(axis=0), 3).T
    grid = np.array(np.meshgrid(x, y, z)).reshape(3, 27).T

    def hidden(shift: float) -> np.ndarray:
        points = grid + [0, shift, 0]
        return np.array([_is_blocked(world, camera, p) for p in points])

    for shift in 0.0, 0.12:
        assert not hidden(shift).any()
    for shift in 0.24, 0.28, 0.32, 0.36:
        assert hidden(shift)[13], "the centre"
        assert hidden(shift).mean() > 0.5


def test_fingertips_start_behind_the_cracker_and_near_its_middle():
    world, _, body = load_scene("cheezit_1")
    tip = world.frame_pose("panda_hand") @ [0, 0, 0.1124, 1]
    low, high = np.sort(_corners(world, body), axis=0)[[0, -1]]
    assert 0.01 < low[1] - tip[1] < 0.1
    assert abs(tip[0] - (low[0] + high[0]) / 2) < 0.0152  # A pad's width.
    assert low[2] < tip[2] < high[2]


def test_probe_reaches_through_the_table_without_touching_it():
    world, _, block = load_scene("planar_push")
    probe = world.plant.GetBodyByName("pusher_probe")
    table = world.plant.GetBodyByName("table")
    (probe_id,), (table_id,) = map(world.shape_ids, (probe, table))
    inspector = world.scene_graph.model_inspector()
    assert inspector.CollisionFiltered(probe_id, table_id)
    assert not inspector.CollisionFiltered(probe_id, world.shape_ids(block)[0])
    shape = inspector.GetShape(probe_id)
    assert shape.radius() == 0.004745
    z = probe.EvalPoseInWorld(world.context).translation()[2]
    assert z - shape.length() / 2 < -0.013 < 0.013 < z + shape.length() / 2


def test_pushers_positions_are_the_probes_axis_in_the_world():
    world, _, _ = load_scene("planar_push")
    instance = world.plant.GetModelInstanceByName("pusher")
    world.plant.SetPositions(world.context, instance, [0.31, -0.02])
    assert world.plant.GetPositionNames(
        instance, add_model_instance_prefix=False
    ) == ["pusher_x_x", "pusher_y_x"]
    p_WP = world.frame_pose("pusher_probe")[:3, 3]
    np.testing.assert_allclose(p_WP, [0.31, -0.02, 0], atol=1e-12)
    assert world.plant.num_actuators() == 2


def test_contacts_of_the_planar_push_have_the_published_friction():
    world, _, block = load_scene("planar_push")
    inspector = world.scene_graph.model_inspector()

    def friction(body) -> CoulombFriction:
        (geometry,) = world.shape_ids(body)
        properties = inspector.GetProximityProperties(geometry)
        return properties.GetProperty("material", "coulomb_friction")

    for other, expected in ("table", 0.35), ("pusher_probe", 0.30):
        combined = CalcContactFrictionFromSurfaceProperties(
            friction(block), friction(world.plant.GetBodyByName(other))
        )
        assert combined.dynamic_friction() == pytest.approx(expected)
        assert combined.static_friction() == pytest.approx(expected)
