from pathlib import Path

from mesh_fixtures import CORNERS, FACES, obj_corners, write_dae, write_mesh
import numpy as np
from pydrake.geometry import Convex, Mesh
from pydrake.multibody.tree import CalcSpatialInertia
import pytest
import trimesh

from pbpf_drake.scene.mesh_conversion import ConvertMesh

WEDGE = np.unique(CORNERS, axis=0)
VOLUME = 0.5 * 0.08 * 0.06 * 0.04
FORMATS = ["stl", "STL", "dae", "ply", "off", "glb"]


def _convert(path: Path, *, hull: bool) -> Path:
    """Converts a mesh file to one beside it."""
    made = path.with_suffix(".made.obj")
    made.write_text(ConvertMesh(path, path.read_bytes(), hull=hull))
    return made


@pytest.mark.parametrize("ending", FORMATS)
def test_a_mesh_keeps_its_size_and_place(tmp_path, ending):
    write_mesh(tmp_path / f"wedge.{ending}")
    for hull in (True, False):
        made = _convert(tmp_path / f"wedge.{ending}", hull=hull)
        np.testing.assert_allclose(obj_corners(made), WEDGE, atol=1e-6)


@pytest.mark.parametrize("ending", FORMATS)
def test_drake_makes_a_hull_with_the_right_volume_of_it(tmp_path, ending):
    write_mesh(tmp_path / f"wedge.{ending}")
    made = _convert(tmp_path / f"wedge.{ending}", hull=True)
    for shape in Convex(str(made)), Mesh(str(made)):
        inertia = CalcSpatialInertia(shape=shape, density=1.0)
        assert inertia.get_mass() == pytest.approx(VOLUME, rel=1e-5)


def test_what_is_looked_at_has_normals(tmp_path):
    write_mesh(tmp_path / "wedge.stl")
    made = _convert(tmp_path / "wedge.stl", hull=False)
    assert "\nvn " in made.read_text()


def test_an_ascii_stl_will_do(tmp_path):
    mesh = trimesh.Trimesh(CORNERS, trimesh.convex.convex_hull(CORNERS).faces)
    (tmp_path / "a.stl").write_text(mesh.export(file_type="stl_ascii"))
    made = _convert(tmp_path / "a.stl", hull=True)
    assert len(obj_corners(made)) == 6


@pytest.mark.parametrize("up", ["X_UP", "Y_UP", "Z_UP"])
def test_colladas_unit_counts_and_its_up_axis_does_not(tmp_path, up):
    write_dae(tmp_path / "wedge.dae", unit=0.001, up=up, moved="10 0 0")
    made = _convert(tmp_path / "wedge.dae", hull=True)
    moved = np.unique(WEDGE + [0.01, 0, 0], axis=0)
    np.testing.assert_allclose(obj_corners(made), moved, atol=1e-6)


def test_a_hull_has_a_limited_number_of_corners(tmp_path):
    ball = trimesh.creation.icosphere(subdivisions=4, radius=0.05)
    ball.export(tmp_path / "ball.stl")
    made = obj_corners(_convert(tmp_path / "ball.stl", hull=True))
    assert len(ball.vertices) > 2500
    assert 200 < len(made) <= 256
    np.testing.assert_allclose(made.max(axis=0), 0.05, atol=5e-4)


@pytest.mark.parametrize(
    "name, data, message",
    [
        ("a.stl", b"", r"a\.stl (can't be read|has no triangles)"),
        ("a.stl", b"x" * 84 + b"short", r"a\.stl has no triangles: is it"),
        ("a.dae", b"<COLLADA/>", r"a\.dae can't be read as DAE: is it whole"),
        ("a.dae", b"no XML", r"a\.dae can't be read as DAE"),
        ("a.ply", b"ply\n", r"a\.ply can't be read as PLY"),
    ],
)
def test_a_damaged_mesh_is_named(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(data)
    with pytest.raises(ValueError, match=message):
        _convert(tmp_path / name, hull=True)


def test_a_flat_mesh_has_no_hull_but_can_be_looked_at(tmp_path):
    flat = trimesh.Trimesh(CORNERS[[0, 1, 3, 4]], [[0, 1, 2], [1, 3, 2]])
    flat.export(tmp_path / "flat.stl")
    with pytest.raises(ValueError, match=r"flat\.stl has no convex hull"):
        _convert(tmp_path / "flat.stl", hull=True)
    assert len(obj_corners(_convert(tmp_path / "flat.stl", hull=False))) == 4


def test_corners_that_are_no_numbers_are_refused(tmp_path):
    (tmp_path / "a.off").write_text(
        "OFF\n3 1 0\n0 0 0\n1 0 nan\n0 1 0\n3 0 1 2"
    )
    with pytest.raises(ValueError, match="has corners that are no numbers"):
        _convert(tmp_path / "a.off", hull=True)


@pytest.mark.parametrize("index", [7, -1, 2**24])
def test_triangles_without_corners_are_refused(tmp_path, index):
    (tmp_path / "a.off").write_text(
        f"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 {index}"
    )
    with pytest.raises(ValueError, match="triangles without corners|be read"):
        _convert(tmp_path / "a.off", hull=True)


@pytest.mark.parametrize("scale", [1e-6, 1e8, 1e38])
def test_a_mesh_of_no_sensible_size_is_refused(tmp_path, scale):
    mesh = trimesh.Trimesh(scale * CORNERS, FACES, process=False)
    mesh.export(tmp_path / "a.stl")
    with pytest.raises(ValueError, match=r"a\.stl is .* m long, without its"):
        _convert(tmp_path / "a.stl", hull=True)


@pytest.mark.parametrize("ending", ["stl", "dae", "ply", "off", "glb"])
def test_a_damaged_mesh_is_converted_or_refused_in_a_sentence(tmp_path, ending):
    path = tmp_path / f"wedge.{ending}"
    write_mesh(path)
    whole, rng = path.read_bytes(), np.random.default_rng(3)
    for i in range(40):
        data = bytearray(whole)
        at = int(rng.integers(len(data) - 8))
        if i % 4 == 0:
            del data[at:]
        elif i % 4 == 1:
            del data[at : at + 7]
        elif i % 4 == 2:
            data[at : at + 4] = b"\xff\xff\xff\x7f"
        else:
            data[at] ^= 1 << rng.integers(8)
        for hull in (True, False):
            try:
                text = ConvertMesh(path, bytes(data), hull=hull)
                assert "\nf " in text
            except ValueError as error:
                assert str(error).startswith(str(path))
