"""What a camera sees, against the projection of its pinhole."""

from filter_fixtures import SCENES
import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.pictures.camera_view import CameraView
from pbpf_drake.scene.pinhole import in_camera, project_points


def test_box_surrounds_what_is_rendered_of_the_object():
    scene = LoadScene(SCENES / "cheezit_1.yaml")
    view = CameraView(scene)
    # Two pictures: with the object in view, and behind the camera.
    X_WO = RigidTransform([0.5, 0.05, 0.12])
    away = RigidTransform([3.0, 0.0, 0.4])
    q = np.zeros(9)
    pictures = [view.Render(q, [X]).astype(int) for X in (X_WO, away)]
    changed = np.any(pictures[0] != pictures[1], axis=2)
    # Some lone pixels change at the edges of other things.
    u, v = (np.flatnonzero(changed.sum(axis=i) > 5) for i in (0, 1))
    p_C = in_camera(view.BoxEdges(0) + X_WO.translation(), scene.camera)
    edges = project_points(p_C, scene.camera)
    low, high = edges.min(axis=(0, 1)), edges.max(axis=(0, 1))
    assert view.BoxEdges(0).shape == (12, 2, 3)
    np.testing.assert_allclose([u.min(), v.min()], low, atol=3)
    np.testing.assert_allclose([u.max(), v.max()], high, atol=3)
