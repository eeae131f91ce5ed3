"""The triangles of a mesh file, or their convex hull, as an OBJ file."""

import io
from pathlib import Path
import warnings

import numpy as np
from scipy.spatial import QhullError
import trimesh

from pbpf_drake.shapes.hull_corners import choose_hull_corners

# How many corners a hull has at most. What is missing of an arm's link is less
# than a millimetre thick, and a contact takes a quarter of the time.
_MOST_CORNERS = 256
# How long a mesh may be, in whatever unit it has: its OBJ file has six digits
# after the point.
_SMALLEST = 1e-4
_LARGEST = 1e5
# The y axis of glTF points up; z does in a model, and Drake turns it the same.
_Z_UP = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])


def ConvertMesh(path: Path, data: bytes, *, hull: bool) -> str:
    """Returns the text of an OBJ file with a mesh or its hull, in meters.

    Args:
        path: the file; its ending says which format it has.
        data: what is in it.
        hull: whether its convex hull is asked for.

    Raises:
        ValueError: it is damaged or has no triangles, or it is flat and so has
            no hull.
    """
    mesh = _load(path, data, path.suffix.lower())
    return _hull_text(path, mesh) if hull else _text(mesh)


def _load(path: Path, data: bytes, ending: str) -> trimesh.Trimesh:
    """Returns all triangles of a mesh file, in one mesh in meters."""
    try:
        with warnings.catch_warnings():
            # pycollada uses what numpy 2.5 deprecates: its authors' affair.
            warnings.simplefilter("ignore", DeprecationWarning)
            loaded = trimesh.load_scene(
                io.BytesIO(data), file_type=ending[1:], process=False
            )
            if ending == ".dae":
                loaded = loaded.convert_units("meters")
            mesh = loaded.to_mesh()
    # A damaged file makes these readers raise nearly anything.
    except Exception as error:
        raise ValueError(
            f"{path} can't be read as {ending[1:].upper()}: is it whole? "
            f"({error})"
        ) from error
    _check(path, mesh)
    if ending == ".glb":
        mesh.apply_transform(_Z_UP)
    return mesh


def _check(path: Path, mesh: trimesh.Trimesh) -> None:
    """Raises a ValueError if a mesh can't be what its author meant."""
    if not len(mesh.faces):
        raise ValueError(f"{path} has no triangles: is it whole?")
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise ValueError(f"{path} has triangles without corners: is it whole?")
    if not np.isfinite(mesh.vertices).all():
        raise ValueError(f"{path} has corners that are no numbers")
    size = float(np.ptp(mesh.vertices, axis=0).max())
    if not _SMALLEST <= size <= _LARGEST:
        raise ValueError(
            f"{path} is {size:.3g} m long, without its scale; expected "
            f"{_SMALLEST:g} to {_LARGEST:g} m: is it whole?"
        )


def _hull_text(path: Path, mesh: trimesh.Trimesh) -> str:
    points = np.asarray(mesh.vertices)
    try:
        chosen = points[choose_hull_corners(points, _MOST_CORNERS)]
        hull = trimesh.convex.convex_hull(chosen)
    except QhullError as error:
        raise ValueError(
            f"{path} has no convex hull: is it flat? Expected a mesh with a "
            "volume"
        ) from error
    return trimesh.exchange.obj.export_obj(hull, include_normals=False)


def _text(mesh: trimesh.Trimesh) -> str:
    """Returns the mesh as OBJ, with the normals that Drake's pictures need."""
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    return trimesh.exchange.obj.export_obj(
        mesh,
        include_normals=True,
        include_color=False,
        include_texture=False,
        digits=6,
    )
