import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
import pytest
from recording_fixtures import SCENES, make_parameters

from pbpf_drake.particle_filter_config import PoseStddev
from pbpf_drake.recording_config import DetectorConfig
from pbpf_drake.scene import LoadScene
from pbpf_drake.simulated_detector import (
    SimulatedDetector,
    VisibilityCamera,
    add_pose_error,
    detection_probability,
    visible_share,
)
from pbpf_drake.truth_model import MakeTruth

EXACT = PoseStddev(position=0.0, rotation=0.0)
X_WC = RigidTransform(RollPitchYaw(-2.0, 0.1, 1.4), [1.1, 0.2, 0.4])
X_WO = RigidTransform(RollPitchYaw(0.3, -0.5, 2.0), [0.4, 0.3, 0.1])


def _detect(visibility: float, *, count: int = 1, seed: int = 0, **config):
    config = {"bias": EXACT, "noise": EXACT, **config}
    detector = SimulatedDetector(
        config=DetectorConfig(**config),
        names=["box"],
        X_WC=X_WC,
        rng=np.random.default_rng(seed),
    )
    return [
        detector.Detect(
            time=0.1 * i, poses=[X_WO], visibility=np.array([visibility])
        )
        for i in range(count)
    ]


def _errors(**config) -> np.ndarray:
    """Returns 2000 errors: 3 of position, in C, and the rotation's angle."""
    X_CO = X_WC.inverse() @ X_WO
    rows = []
    for (detection,) in _detect(1.0, count=2000, **config):
        R = X_CO.rotation().InvertAndCompose(detection.X_CO.rotation())
        shift = detection.X_CO.translation() - X_CO.translation()
        rows.append([*shift, R.ToAngleAxis().angle()])
    return np.array(rows)


def test_visible_share_counts_pixels():
    alone = np.array([[7, 7, 7, 7], [0, 0, 7, 7]])
    labels = np.array([[7, 7, 3, 3], [0, 0, 7, 3]])
    assert visible_share(labels, alone, 7) == 0.5
    assert visible_share(alone, alone, 7) == 1.0


def test_what_is_outside_the_image_is_not_visible():
    empty = np.zeros((2, 4), dtype=int)
    assert visible_share(empty, empty, 7) == 0.0


def test_chance_of_a_detection_grows_from_hidden_to_clear():
    config = DetectorConfig(hidden_visibility=0.4, clear_visibility=0.6)
    chances = [detection_probability(v, config) for v in (0, 0.4, 0.5, 0.6, 1)]
    np.testing.assert_allclose(chances, [0, 0, 0.5, 1, 1], atol=1e-12)


@pytest.mark.parametrize(
    "visibility, share", [(0.44, 0.0), (0.5, 1 / 3), (0.55, 2 / 3), (0.61, 1.0)]
)
def test_detections_vanish_as_the_object_does(visibility, share):
    count = sum(len(d) for d in _detect(visibility, count=3000))
    assert count / 3000 == pytest.approx(share, abs=0.03 * (0 < share < 1))


def test_a_detection_without_errors_is_the_pose_in_the_camera():
    ((detection,),) = _detect(1.0, latency=0.02)
    assert (X_WC @ detection.X_CO).IsNearlyEqualTo(X_WO, 1e-12)
    assert (detection.name, detection.time) == ("box", 0.0)
    assert detection.received == 0.02


def test_bias_is_the_same_in_all_detections_of_a_run():
    bias = PoseStddev(position=0.02, rotation=0.1)
    errors = _errors(bias=bias)
    np.testing.assert_allclose(errors, np.tile(errors[0], (2000, 1)), atol=1e-9)
    assert np.linalg.norm(errors[0, :3]) > 1e-3
    assert errors[0, 3] > 1e-3
    assert not np.allclose(errors[0], _errors(bias=bias, seed=1)[0])


def test_noise_has_the_configured_spread():
    errors = _errors(noise=PoseStddev(position=0.003, rotation=0.02))
    np.testing.assert_allclose(errors[:, :3].mean(axis=0), 0, atol=3e-4)
    np.testing.assert_allclose(errors[:, :3].std(axis=0), 0.003, rtol=0.06)
    assert np.sqrt(np.mean(errors[:, 3] ** 2)) == pytest.approx(0.02, rel=0.06)


def test_a_missed_detection_changes_no_other():
    noise = PoseStddev(position=0.003, rotation=0.02)
    all_of_them = _detect(1.0, count=50, noise=noise)
    some = _detect(0.5, count=50, noise=noise)
    found = [i for i, detections in enumerate(some) if detections]
    assert 5 < len(found) < 40
    for i in found:
        expected, got = all_of_them[i][0].X_CO, some[i][0].X_CO
        assert got.IsExactlyEqualTo(expected)


def test_pose_error_turns_about_the_object_itself():
    X_CO = RigidTransform([1.0, 2.0, 3.0])
    moved = add_pose_error(X_CO, np.array([0, 0, 0.5, 0.1, 0.0, -0.1]))
    np.testing.assert_allclose(moved.translation(), [1.1, 2.0, 2.9])
    expected = RollPitchYaw(0, 0, 0.5).ToRotationMatrix()
    np.testing.assert_allclose(
        moved.rotation().matrix(), expected.matrix(), atol=1e-12
    )


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
