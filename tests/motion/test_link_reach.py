import numpy as np
from physics_fixtures import FLAT, make_model
import pytest

from pbpf_drake.motion.link_reach import link_distances
from pbpf_drake.motion.robot_links import RobotLinks
from pbpf_drake.shapes.bounding_boxes import MakeBoundingBoxes

# From the middle of the block to that of the probe, where they touch.
TOUCHING = 0.045 + 0.004745


@pytest.fixture(scope="module")
def model():
    return make_model("block", "soup")


def _objects(model):
    return MakeBoundingBoxes(
        model.diagram.scene_graph().model_inspector(),
        [model.geometries(body) for body in model.models.objects],
    )


def _near(model, x_probe, x_block, *, margin, active=(True, True), x_soup=5.0):
    """Whether a probe comes near: where it is, where the block is."""
    links = RobotLinks(model=model)
    context = model.diagram.plant().CreateDefaultContext()
    poses = np.zeros((len(x_block), 2, 7))
    poses[:, :, :4] = FLAT
    poses[:, 0, 4] = x_block
    poses[:, 1, 4] = x_soup
    distances = link_distances(
        object_boxes=_objects(model),
        poses=poses,
        active=np.array(active),
        link_boxes=links.boxes,
        link_poses=np.stack([links.Poses([x, 0.0], context) for x in x_probe]),
        margin=np.full(len(x_block), margin),
    )
    assert distances.shape == (len(x_block), 1)
    return list(np.isfinite(distances[:, 0]))


def test_what_is_closer_than_the_margin_is_near(model):
    x = -TOUCHING - np.array([0.011, 0.009, -0.02])
    assert _near(model, [0.0], -x, margin=0.01) == [False, True, True]


def test_the_distance_is_that_of_the_boxes(model):
    gaps = [0.003, 0.0, -0.004]
    links = RobotLinks(model=model)
    context = model.diagram.plant().CreateDefaultContext()
    poses = np.zeros((3, 2, 7))
    poses[..., 0] = 1.0
    poses[:, 0, 4] = TOUCHING + np.array(gaps)
    poses[:, 1, 4] = 5.0
    found = link_distances(
        object_boxes=_objects(model),
        poses=poses,
        active=np.ones(2, dtype=bool),
        link_boxes=links.boxes,
        link_poses=links.Poses(np.zeros(2), context)[None],
        margin=np.full(3, 0.01),
    )
    np.testing.assert_allclose(found[:, 0], gaps, atol=1e-12)


def test_anywhere_on_the_way_counts(model):
    far = [2 * TOUCHING + 0.05]
    assert _near(model, [0.0], far, margin=0.01) == [False]
    assert _near(model, [0.0, 0.1], far, margin=0.01) == [True]
    assert _near(model, [0.0, 0.1, 0.0], far, margin=0.01) == [True]


def test_only_objects_that_are_tracked_count(model):
    assert _near(model, [0.0], [0.0], margin=0.0) == [True]
    away = {"active": (False, True), "margin": 0.0}
    assert _near(model, [0.0], [0.0], **away) == [False]
    assert _near(model, [0.0], [0.0], x_soup=0.0, **away) == [True]


@pytest.mark.filterwarnings("error")
def test_what_is_nowhere_is_near_nothing(model):
    x = [np.nan, np.inf, 0.0]
    assert _near(model, [0.0], x, margin=0.01) == [False, False, True]
