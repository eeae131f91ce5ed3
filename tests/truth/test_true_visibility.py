import numpy as np
from pydrake.math import RigidTransform
import pytest
from recording_fixtures import SCENES, make_parameters

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.truth.true_visibility import VisibilityCamera, visible_share
from pbpf_drake.truth.truth_model import MakeTruth


def test_visible_share_counts_pixels():
    alone = np.array([[7, 7, 7, 7], [0, 0, 7, 7]])
    labels = np.array([[7, 7, 3, 3], [0, 0, 7, 3]])
    assert visible_share(labels, alone, 7) == 0.5
    assert visible_share(alone, alone, 7) == 1.0


def test_what_is_outside_the_image_is_not_visible():
    empty = np.zeros((2, 4), dtype=int)
    assert visible_share(empty, empty, 7) == 0.0


@pytest.fixture(scope="module")
def cheezit():
    scene = LoadScene(SCENES / "cheezit_1.yaml")
    truth = MakeTruth(scene=scene, parameters=make_parameters(scene))
    camera = VisibilityCamera(
        diagram=truth.diagram,
        objects=truth.models.objects,
        camera=scene.camera,
    )
    return scene, truth, camera


def _first_hit(origin, rays, X_WB: RigidTransform, size) -> np.ndarray:
    """Where rays (N, 3) enter a box, in their lengths; inf where they miss."""
    p = X_WB.inverse() @ origin
    d = rays @ X_WB.rotation().matrix()
    near, far = (-size / 2 - p) / d, (size / 2 - p) / d
    enter = np.minimum(near, far).max(axis=1)
    leave = np.maximum(near, far).min(axis=1)
    return np.where((enter <= leave) & (leave > 0), enter, np.inf)


def _expected_visibility(camera, X_WO: RigidTransform, X_WB) -> float:
    """The share of pixels with the box that the obstacle doesn't cover."""
    v, u = np.mgrid[0 : camera.height : 2, 0 : camera.width : 2]
    rays = np.column_stack(
        [
            (u.ravel() - camera.cx) / camera.fx,
            (v.ravel() - camera.cy) / camera.fy,
            np.ones(u.size),
        ]
    )
    X_WC = camera.pose()
    rays = rays @ X_WC.rotation().matrix().T
    origin = X_WC.translation()
    box = _first_hit(origin, rays, X_WO, np.array([0.16, 0.21344, 0.061]))
    wall = _first_hit(origin, rays, X_WB, np.array([0.1968, 0.2505, 0.0725]))
    return np.mean(box[np.isfinite(box)] < wall[np.isfinite(box)])


@pytest.mark.parametrize("y", [0.15, 0.3, 0.33, 0.36, 0.4, 0.5, 0.54])
def test_visibility_agrees_with_rays_against_two_boxes(cheezit, y):
    scene, truth, camera = cheezit
    plant = truth.diagram.plant()
    context = plant.CreateDefaultContext()
    box = plant.get_body(truth.models.objects[0])
    wall = plant.GetBodyByName("scene_1_obstacle")
    X_WO = box.EvalPoseInWorld(context)
    X_WO.set_translation([0.43, y, 0.08])
    plant.SetFreeBodyPose(context, box, X_WO)
    (visibility,) = camera.CalcVisibility(plant.GetPositions(context))
    expected = _expected_visibility(
        scene.camera, X_WO, wall.EvalPoseInWorld(context)
    )
    assert visibility == pytest.approx(expected, abs=0.02)


def test_an_object_behind_the_camera_is_not_visible(cheezit):
    _, truth, camera = cheezit
    plant = truth.diagram.plant()
    context = plant.CreateDefaultContext()
    box = plant.get_body(truth.models.objects[0])
    plant.SetFreeBodyPose(context, box, RigidTransform([2.0, 0.1, 0.1]))
    assert camera.CalcVisibility(plant.GetPositions(context)) == [0.0]
