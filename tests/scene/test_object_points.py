import numpy as np
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.scene.object_points import MakeObjectPoints
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder

SCENE = data_folder("diagrams") / "scenes" / "cheezit_gelatin_soup.yaml"


@pytest.fixture(scope="module")
def model():
    return MakePredictionModel(LoadScene(SCENE))


@pytest.mark.parametrize(
    "index, half_size",
    [(0, [0.08, 0.10672, 0.0305]), (1, [0.04255, 0.03685, 0.01395])],
)
def test_points_of_a_box_are_on_its_sides_and_at_its_corners(
    model, index, half_size
):
    points = MakeObjectPoints(model, index)
    relative = np.abs(points) / half_size
    np.testing.assert_allclose(relative.max(axis=1), 1)
    assert len(points) == 508
    assert np.isclose(relative, 1).all(axis=1).sum() == 8
    # Each side has its share of the points, by area.
    areas = np.prod(half_size) / np.array(half_size)
    shares = np.isclose(relative[:500], 1).mean(axis=0)
    np.testing.assert_allclose(shares, areas / areas.sum(), atol=0.02)


def test_points_of_the_can_are_on_its_surface_about_local_y(model):
    points = MakeObjectPoints(model, 2, num_points=200)
    radius = np.hypot(points[:, 0], points[:, 2]) / 0.03383
    height = np.abs(points[:, 1]) / 0.05
    np.testing.assert_allclose(np.maximum(radius, height), 1)
    rims = np.isclose(radius, 1) & np.isclose(height, 1)
    assert rims[200:].all() and not rims[:200].any()


def test_points_are_always_the_same(model):
    first, second = (MakeObjectPoints(model, 1) for _ in range(2))
    np.testing.assert_array_equal(first, second)
