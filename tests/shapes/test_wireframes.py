import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    Sphere,
)
import pytest

from pbpf_drake.shapes.wireframes import ShapeEdges


def _ends(edges):
    assert edges.shape[1:] == (2, 3)
    return edges.reshape(-1, 3)


def _length(edges):
    return np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).sum()


def test_box_has_twelve_edges_along_its_axes():
    edges = ShapeEdges(Box(0.2, 0.4, 0.6))
    assert edges.shape == (12, 2, 3)
    assert {tuple(p) for p in np.abs(_ends(edges))} == {(0.1, 0.2, 0.3)}
    moved = np.abs(edges[:, 1] - edges[:, 0])
    np.testing.assert_allclose(np.sort(moved, axis=1)[:, :2], 0)
    np.testing.assert_allclose(
        np.sort(moved.max(axis=1)), np.repeat([0.2, 0.4, 0.6], 4)
    )
    assert len({tuple(np.sort(e, axis=0).ravel()) for e in edges}) == 12


def test_cylinder_has_two_circles_and_sides():
    edges = ShapeEdges(Cylinder(0.3, 2.0))
    ends = _ends(edges)
    np.testing.assert_allclose(np.hypot(*ends.T[:2]), 0.3)
    np.testing.assert_allclose(np.abs(ends[:, 2]), 1.0)
    # A polygon of 24 sides is 0.3 % shorter than its circle.
    expected = 2 * 2 * np.pi * 0.3 + 4 * 2.0
    assert _length(edges) == pytest.approx(expected, rel=3e-3)


@pytest.mark.parametrize(
    ("shape", "radii"),
    [(Sphere(0.2), [0.2] * 3), (Ellipsoid(0.1, 0.2, 0.3), [0.1, 0.2, 0.3])],
)
def test_ellipsoid_has_three_ellipses_on_its_surface(shape, radii):
    edges = ShapeEdges(shape)
    ends = _ends(edges)
    np.testing.assert_allclose(np.sum((ends / radii) ** 2, axis=1), 1)
    for axis in range(3):
        flat = np.all(np.abs(edges[..., axis]) < 1e-12, axis=1)
        assert flat.sum() == 24
        # Each is closed: the last segment ends where the first begins.
        ring = edges[flat]
        np.testing.assert_allclose(
            ring[:, 1], np.roll(ring[:, 0], -1, axis=0), atol=1e-12
        )


def test_capsule_lies_on_its_surface_and_reaches_both_tips():
    ends = _ends(ShapeEdges(Capsule(0.1, 0.5)))
    on_axis = np.clip(ends[:, 2], -0.25, 0.25)
    distances = np.linalg.norm(
        ends - np.stack([0 * on_axis, 0 * on_axis, on_axis], axis=1), axis=1
    )
    np.testing.assert_allclose(distances, 0.1)
    assert ends[:, 2].max() == pytest.approx(0.35)
    assert ends[:, 2].min() == pytest.approx(-0.35)


def test_mesh_has_the_edges_of_its_box(tmp_path):
    path = tmp_path / "wedge.obj"
    corners = [(1, 1, 2), (3, 1, 2), (1, 4, 2), (1, 1, 8)]
    faces = [(1, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4)]
    path.write_text(
        "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
        + "".join(f"f {a} {b} {c}\n" for a, b, c in faces)
    )
    edges = ShapeEdges(Mesh(str(path)))
    assert edges.shape == (12, 2, 3)
    # All corners of the mesh are between the box's opposite faces.
    origin = edges[0, 0]
    for start, end in edges:
        if np.allclose(start, origin) or np.allclose(end, origin):
            along = end - start
            shares = (np.array(corners) - start) @ along / (along @ along)
            assert shares.min() > -1e-9 and shares.max() < 1 + 1e-9


def test_a_shape_without_a_size_is_refused():
    with pytest.raises(ValueError, match="expected a shape of some size"):
        ShapeEdges(HalfSpace())
