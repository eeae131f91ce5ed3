import numpy as np
from pydrake.geometry import Meshcat, Sphere
from pydrake.math import RigidTransform
import pytest
from visual_fixtures import (
    Page,
    has_number,
    has_text,
    write_visual_scene,
)

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.views.scene_meshcat import SaveReplay, SceneMeshcat

CAMERA = "/Cameras/default/rotated/<object>"


@pytest.fixture
def meshcat():
    meshcat = Meshcat()
    yield meshcat
    meshcat.Delete()


class _PoseCatcher:
    """Takes the place of Meshcat, and keeps the view that it is given."""

    def __getattr__(self, name):
        return lambda *args, **kwargs: None

    def SetCameraPose(self, camera_in_world, target_in_world):
        self.camera, self.target = camera_in_world, target_in_world


def _find_transform(page, path):
    """Returns the 4 × 4 matrix, which is the last thing in its message."""
    (command,) = page.find("set_transform", path)
    values = command[command.index(b"matrix") + 9 :]
    numbers = np.frombuffer(values, dtype="u1").reshape(16, 9)[:, 1:]
    return numbers.copy().view(">f8").reshape(4, 4).T


def test_robot_and_fixed_models_are_drawn_and_objects_are_not(
    meshcat, tmp_path
):
    dut = SceneMeshcat(meshcat=meshcat, scene=write_visual_scene(tmp_path))
    page = Page(meshcat)
    for path in ("arm/base/0", "arm/hand/0", "wall/wall/0"):
        assert page.find("set_object", f"scene/{path}")
    for path in ("arm/invisible", "red", "blue"):
        assert not meshcat.HasPath(f"scene/{path}")
    assert dut.num_positions == 2
    assert dut.object_names == ("red", "blue")
    assert [len(dut.object_geometries[n]) for n in dut.object_names] == [2, 2]


def test_bodies_are_where_the_scene_puts_them(meshcat, tmp_path):
    SceneMeshcat(meshcat=meshcat, scene=write_visual_scene(tmp_path))
    page = Page(meshcat)
    for path, p in (
        ("arm/base", [0.0, -0.5, 0.25]),
        ("wall/wall", [0.375, 0.125, 0.0]),
        ("wall/wall/0", [0.0, 0.0, 0.1]),
    ):
        found = _find_transform(page, f"scene/{path}")
        np.testing.assert_array_equal(found, RigidTransform(p).GetAsMatrix4())


def test_robot_follows_its_joints(meshcat, tmp_path):
    dut = SceneMeshcat(meshcat=meshcat, scene=write_visual_scene(tmp_path))
    dut.SetJointPositions(np.array([0.125, 0.5]), time=1.0)
    page = Page(meshcat)
    found = _find_transform(page, "scene/arm/hand")
    np.testing.assert_allclose(found[:3, 3], [0.0, -0.375, 0.25], atol=1e-15)
    found = _find_transform(page, "scene/arm/base")
    np.testing.assert_allclose(found[:3, 3], [0.0, -0.5, 0.25], atol=1e-15)


def test_view_is_from_above_the_scenes_camera(meshcat, tmp_path):
    scene = write_visual_scene(tmp_path)
    catcher = _PoseCatcher()
    SceneMeshcat(meshcat=catcher, scene=scene).SetCameraView()
    # The camera looks along -x, level; the objects are in its middle, 1 m off.
    np.testing.assert_allclose(catcher.target, [0.6, 0.0, 0.1], atol=1e-12)
    offset = catcher.camera - catcher.target
    angle = np.deg2rad(20)
    expected = [np.cos(angle), 0.0, np.sin(angle)]
    np.testing.assert_allclose(offset, expected, atol=1e-12)
    SceneMeshcat(meshcat=meshcat, scene=scene).SetCameraView()
    commands = Page(meshcat).find("set_property", CAMERA)
    (zoom,) = [c for c in commands if has_text(c, "zoom")]
    expected = np.tan(np.deg2rad(37.5)) / (240 / scene.camera.fy)
    assert has_number(zoom, expected)


@pytest.mark.parametrize("name", ["cheezit_1", "planar_push"])
def test_view_of_a_shipped_scene_has_its_objects_in_the_middle(name):
    scene = LoadScene(data_folder("diagrams") / "scenes" / f"{name}.yaml")
    catcher = _PoseCatcher()
    SceneMeshcat(meshcat=catcher, scene=scene).SetCameraView()
    p_WO = [
        np.asarray(pose.translation)
        for d in scene.directives
        if d.add_model and d.add_model.name in scene.tracked
        for pose in d.add_model.default_free_body_pose.values()
    ]
    to_target = catcher.target - catcher.camera
    to_object = np.mean(p_WO, axis=0) - catcher.camera
    cosine = to_target @ to_object
    cosine /= np.linalg.norm(to_target) * np.linalg.norm(to_object)
    assert cosine > np.cos(np.deg2rad(20))
    # Neither straight down, where no side is up, nor from below the table.
    elevation = np.arcsin(-to_target[2] / np.linalg.norm(to_target))
    assert np.deg2rad(19) < elevation < np.deg2rad(61)


def test_view_of_a_camera_above_is_from_the_lower_side_of_its_image():
    scene = LoadScene(data_folder("diagrams") / "scenes" / "planar_push.yaml")
    catcher = _PoseCatcher()
    SceneMeshcat(meshcat=catcher, scene=scene).SetCameraView()
    # The world's y points up in its image.
    up = -scene.camera.pose().rotation().col(1)
    np.testing.assert_allclose(up, [0.0, 1.0, 0.0], atol=1e-12)
    offset = catcher.camera - catcher.target
    expected = [0.0, -np.cos(np.pi / 3), np.sin(np.pi / 3)]
    direction = offset / np.linalg.norm(offset)
    np.testing.assert_allclose(direction, expected, atol=1e-12)


def test_replay_holds_shapes_and_motion_and_needs_no_network(meshcat, tmp_path):
    meshcat.StartRecording(set_visualizations_while_recording=False)
    meshcat.SetObject("ball", Sphere(0.123))
    for time, x in ((0.0, 0.1), (1.0, 0.7)):
        meshcat.SetTransform(
            "ball", RigidTransform([x, 0.0, 0.0]), time_in_recording=time
        )
    SaveReplay(meshcat, tmp_path / "replay.html")
    page = Page(tmp_path / "replay.html")
    (ball,) = page.find("set_object", "ball")
    assert has_number(ball, 0.123)
    (motion,) = page.find("set_animation", "ball")
    assert has_number(motion, 0.1) and has_number(motion, 0.7)
    html = (tmp_path / "replay.html").read_text("utf-8")
    assert "ground truth" in html.split("<script")[0]
    for attribute in ("src=", "href="):
        for quote in ('"', "'"):
            assert f"<script {attribute}{quote}http" not in html
            assert f"<link {attribute}{quote}http" not in html
