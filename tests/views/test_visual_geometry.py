import numpy as np
from pydrake.common import MemoryFile
from pydrake.geometry import (
    Box,
    Convex,
    Cylinder,
    HalfSpace,
    InMemoryMesh,
    Mesh,
    Meshcat,
    Rgba,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
import pytest
from visual_fixtures import Page, has_number

from pbpf_drake.views.visual_geometry import (
    DrawGeometries,
    DrawOutline,
    MakeSilhouette,
    VisualGeometry,
)

RED = Rgba(0.8, 0.125, 0.0)
X = RigidTransform(RollPitchYaw(0.3, 0.0, 1.0), [0.1, 0.2, 0.3])
_CORNERS = np.array(np.meshgrid([0, 0.3], [0, 0.2], [0, 0.1])).reshape(3, 8).T
_FACES = ("1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4")
_OBJ = "\n".join(
    [f"v {x} {y} {z}" for x, y, z in _CORNERS] + [f"f {f}" for f in _FACES]
)


@pytest.fixture
def meshcat():
    meshcat = Meshcat()
    yield meshcat
    meshcat.Delete()


def _brick(kind):
    """Returns a mesh of 0.3 × 0.2 × 0.1, with a corner at its origin."""
    file = MemoryFile(_OBJ, ".obj", "brick")
    return kind(mesh_data=InMemoryMesh(mesh_file=file))


def test_geometries_are_drawn_at_their_poses_in_their_colors(meshcat):
    geometries = [
        VisualGeometry(Sphere(0.1), RigidTransform(), RED),
        VisualGeometry(Box(0.1, 0.2, 0.3), X, RED),
    ]
    DrawGeometries(meshcat, "a/b", geometries)
    page = Page(meshcat)
    for i in range(2):
        (command,) = page.find("set_object", f"a/b/{i}")
        # 0.8, 0.125 and 0 of 255, as one number.
        assert (204 << 16 | 31 << 8).to_bytes(4, "big") in command
    (command,) = page.find("set_transform", "a/b/1")
    assert all(has_number(command, x) for x in X.translation())
    assert all(has_number(command, x) for x in X.rotation().matrix().flat)


def test_tint_is_mixed_with_the_own_color(meshcat):
    geometries = [VisualGeometry(Sphere(0.1), X, RED)]
    DrawGeometries(meshcat, "a", geometries, tint=Rgba(0.0, 0.875, 0.0))
    (command,) = Page(meshcat).find("set_object", "a/0")
    assert (102 << 16 | 127 << 8).to_bytes(4, "big") in command


def test_tint_reaches_the_materials_of_a_mesh(meshcat):
    geometries = [VisualGeometry(_brick(Mesh), X, RED)]
    DrawGeometries(meshcat, "a", geometries, tint=Rgba(0.0, 0.875, 0.0))
    (command,) = Page(meshcat).find("set_property", "a/0")
    assert b"color" in command and has_number(command, 0.875)


def test_silhouette_leaves_out_what_is_painted_on():
    box = VisualGeometry(Box(0.1, 0.2, 0.3), X, RED)
    label = VisualGeometry(Box(0.101, 0.1, 0.1), X, RED)
    inside = VisualGeometry(Sphere(0.02), X, RED)
    handle_pose = X @ RigidTransform([0.09, 0.0, 0.0])
    handle = VisualGeometry(Cylinder(0.02, 0.1), handle_pose, RED)
    likeness = MakeSilhouette([label, inside, handle, box], Rgba(0, 0, 1), 0.5)
    assert [g.shape for g in likeness] == [box.shape, handle.shape]
    assert [g.rgba for g in likeness] == [Rgba(0, 0, 1, 0.5)] * 2
    assert likeness[1].X_BG.IsExactlyEqualTo(handle_pose)


@pytest.mark.parametrize("kind", [Mesh, Convex])
def test_silhouette_of_a_mesh_is_its_box(kind):
    geometry = VisualGeometry(_brick(kind), X, RED)
    (likeness,) = MakeSilhouette([geometry], RED, 0.5)
    assert isinstance(likeness.shape, Box)
    size = np.asarray(likeness.shape.size())
    np.testing.assert_allclose(sorted(size), [0.1, 0.2, 0.3], rtol=1e-3)
    p_B = (X @ _CORNERS.T).T
    p_G = (likeness.X_BG.inverse() @ p_B.T).T
    np.testing.assert_allclose(2 * np.abs(p_G), [size] * 8, rtol=1e-3)


def test_a_shape_without_a_size_is_named():
    geometry = VisualGeometry(HalfSpace(), X, RED)
    with pytest.raises(ValueError, match="HalfSpace.*a shape with a size"):
        MakeSilhouette([geometry], RED, 0.5)


class _LineCatcher:
    """Takes the place of Meshcat, and keeps the lines that it is given."""

    def SetLineSegments(self, path, *, start, end, line_width, rgba):
        self.segments = np.stack([start.T, end.T], axis=1)


def test_outline_is_the_edges_of_the_box_around_all_geometries(meshcat):
    geometries = [
        VisualGeometry(Sphere(0.1), RigidTransform([1.0, 0.0, 0.0]), RED),
        VisualGeometry(Box(0.2, 0.6, 0.4), RigidTransform([0, 0, 0.5]), RED),
    ]
    catcher = _LineCatcher()
    DrawOutline(catcher, "outline", geometries, RED)
    low, high = np.array([-0.1, -0.3, -0.1]), np.array([1.1, 0.3, 0.7])
    points = catcher.segments.reshape(-1, 3)
    assert np.all(np.isclose(points, low) | np.isclose(points, high))
    directions = catcher.segments[:, 1] - catcher.segments[:, 0]
    # Each of the three directions has four edges, all of them different.
    for axis in range(3):
        edge = np.eye(3)[axis] * (high - low)
        found = np.all(np.isclose(directions, edge), axis=-1)
        assert found.sum() == 4
    middles = catcher.segments.mean(axis=1)
    assert len(np.unique(middles.round(9), axis=0)) == 12
    DrawOutline(meshcat, "outline", geometries, RED)
    assert meshcat.HasPath("outline")
