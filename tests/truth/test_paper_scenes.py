"""The paper's scenes: what there is to see and to push at the start."""

from model_world import World, load_scene
import numpy as np
from pydrake.geometry import Box, Cylinder
import pytest
from recording_fixtures import SCENES

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.paper.paper_values import SCENES as NAMES
from pbpf_drake.shapes.box_corners import box_corners


def _corners(world: World, name: str) -> np.ndarray:
    """The corners of the box around an object's shape (8, 3), in the world."""
    body = world.plant.GetBodyByName(name)
    (geometry,) = world.shape_ids(body)
    inspector = world.scene_graph.model_inspector()
    shape = inspector.GetShape(geometry)
    if isinstance(shape, Cylinder):
        half = np.array([shape.radius(), shape.radius(), shape.length() / 2])
    else:
        assert isinstance(shape, Box)
        half = shape.size() / 2
    X_WG = body.EvalPoseInWorld(world.context) @ inspector.GetPoseInFrame(
        geometry
    )
    return (X_WG @ box_corners(half).T).T


@pytest.mark.parametrize("name", NAMES)
def test_recording_fits_the_paper(name):
    config = LoadScene(SCENES / f"{name}.yaml").recording
    config.ValidateOrThrow()
    assert 20 <= config.duration <= 36
    assert config.duration > config.path.waypoints[-1].time
    for before, here in zip(
        config.path.waypoints, config.path.waypoints[1:], strict=False
    ):
        way = np.subtract(here.translation, before.translation)
        assert np.linalg.norm(way) / (here.time - before.time) < 0.025


@pytest.mark.parametrize("name", NAMES)
def test_objects_rest_on_the_table_and_are_in_the_image_all_the_way(name):
    world, camera, _ = load_scene(name)
    scene = LoadScene(SCENES / f"{name}.yaml")
    X_CW = camera.pose().inverse()
    hand = np.array([w.translation for w in scene.recording.path.waypoints])
    # What the hand reaches later is pushed less far; in scene 4 nothing is.
    reach = {"cheezit_2": 0.27, "soup_2": 0.31, "cheezit_4": 0.0}
    push = reach.get(name, hand[-1, 1] - 0.045)
    for tracked in scene.object_names():
        corners = _corners(world, tracked)
        assert abs(corners[:, 2].min()) < 1e-3
        for shift in 0.0, push:
            x, y, z = X_CW @ (corners + [0, shift, 0]).T
            u = camera.fx * x / z + camera.cx
            v = camera.fy * y / z + camera.cy
            assert np.all((z > 0) & (u > 0) & (u < camera.width - 1))
            assert np.all((v > 0) & (v < camera.height - 1))


@pytest.mark.parametrize("name", NAMES)
def test_a_can_looks_the_same_however_it_is_turned_about_its_axis(name):
    world, _, _ = load_scene(name)
    inspector = world.scene_graph.model_inspector()
    for tracked, config in LoadScene(SCENES / f"{name}.yaml").tracked.items():
        body = world.plant.GetBodyByName(tracked)
        (geometry,) = world.shape_ids(body)
        if not isinstance(inspector.GetShape(geometry), Cylinder):
            assert config.symmetry.axis == []
            continue
        R_BG = inspector.GetPoseInFrame(geometry).rotation()
        axis = R_BG @ [0.0, 0.0, 1.0]
        assert config.symmetry.order == 0
        assert abs(np.dot(config.symmetry.axis, axis)) == pytest.approx(1)


@pytest.mark.parametrize("name", NAMES)
def test_nothing_overlaps_at_the_start(name):
    world, _, _ = load_scene(name)
    deepest = world.query().ComputePointPairPenetration()
    assert all(pair.depth < 1e-3 for pair in deepest)


@pytest.mark.parametrize("kind", ["cheezit", "soup"])
def test_scenes_differ_by_what_hides_the_object(kind):
    scenes = [LoadScene(SCENES / f"{kind}_{i}.yaml") for i in (1, 2, 3)]
    has_obstacle = [
        any(
            d.add_model and d.add_model.name == "obstacle" for d in s.directives
        )
        for s in scenes
    ]
    assert has_obstacle == [True, False, False]
    # Their runs, and so the errors of their detectors, are independent.
    assert len({s.recording.seed for s in scenes}) == 3


def test_support_is_wide_enough_for_the_corners_of_the_box_it_holds():
    """The prediction has contact points at corners of boxes only."""
    world, _, _ = load_scene("cheezit_4")
    box = _corners(world, "cracker")[:, 0]
    support = _corners(world, "scene_4_support")[:, 0]
    assert support.min() + 0.02 < box.min()
    assert box.max() < support.max() - 0.02
