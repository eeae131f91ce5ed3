"""Mesh files that Drake can't read, turned into OBJ files that it can.

Drake reads OBJ, glTF and VTK. Robots for ROS come with STL and COLLADA (.dae),
scans with PLY. What collides counts as its convex hull everywhere in this
package, so the hull is all that is kept of it. What is only looked at is kept
whole, without its colours.

The files are written to a cache, under a name made from what is in the mesh: a
mesh is converted once, and a mesh that has changed is converted again.
"""

import atexit
import functools
import hashlib
import io
import os
from pathlib import Path
import shutil
import tempfile

import numpy as np
from scipy.spatial import QhullError
import trimesh

from pbpf_drake.shapes.hull_corners import choose_hull_corners

# How the names of mesh files end that Drake reads itself, and that are turned
# into an OBJ file first.
DRAKE_ENDINGS = (".obj", ".gltf", ".vtk")
CONVERTED_ENDINGS = (".stl", ".dae", ".ply", ".off", ".glb")
# How many corners a hull has at most. What is missing of an arm's link is less
# than a millimetre thick, and a contact takes a quarter of the time.
_MOST_CORNERS = 256
# Part of the names in the cache: it changes with what is made of a mesh.
_VERSION = "1"
# The y axis of glTF points up; z does in a model, and Drake turns it the same.
_Z_UP = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1.0]])


def ReadableMesh(path: Path, *, hull: bool) -> Path:
    """Returns a mesh file that Drake can read: this one, or an OBJ of it.

    A COLLADA file's unit is applied, and its up axis is not, as in ROS.

    Args:
        path: the mesh file.
        hull: whether the OBJ file has the mesh's convex hull, to collide with,
            and not the mesh, to look at.

    Raises:
        ValueError: it is no file, its format is unknown, it is damaged or has
            no triangles, or it is flat and so has no hull.
    """
    if not path.is_file():
        raise ValueError(f"{path} is no file; expected a mesh")
    ending = path.suffix.lower()
    if ending in DRAKE_ENDINGS:
        return path
    if ending not in CONVERTED_ENDINGS:
        raise ValueError(
            f"{path} ends in {ending!r}; expected a mesh that ends in one of "
            f"{', '.join(DRAKE_ENDINGS + CONVERTED_ENDINGS)}: export it as one"
        )
    data = path.read_bytes()
    parts = (_VERSION.encode(), ending.encode(), str(hull).encode(), data)
    key = hashlib.sha256(b"|".join(parts)).hexdigest()
    cached = CacheFolder() / f"{path.stem[:60]}-{key[:24]}.obj"
    if not cached.is_file():
        mesh = _load(path, data, ending)
        WriteWhole(cached, _hull_text(path, mesh) if hull else _text(mesh))
    return cached


def CacheFolder() -> Path:
    """Returns the folder that converted files are in; it exists.

    It is pbpf_drake in XDG_CACHE_HOME or in ~/.cache. Where none can be
    written, it is a temporary one, which goes when this process ends.
    """
    try:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        folder = Path(home) / "pbpf_drake"
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return _temporary_folder()
    return folder if os.access(folder, os.W_OK) else _temporary_folder()


def WriteWhole(path: Path, text: str) -> None:
    """Writes a file so that nobody ever sees a part of it."""
    with tempfile.NamedTemporaryFile(
        "w", dir=path.parent, delete=False, encoding="utf-8"
    ) as file:
        file.write(text)
    os.replace(file.name, path)


@functools.cache
def _temporary_folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="pbpf_drake_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder


def _load(path: Path, data: bytes, ending: str) -> trimesh.Trimesh:
    """Returns all triangles of a mesh file, in one mesh in meters."""
    try:
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
    if not len(mesh.faces):
        raise ValueError(f"{path} has no triangles: is it whole?")
    if not np.isfinite(mesh.vertices).all():
        raise ValueError(f"{path} has corners that are no numbers")
    if ending == ".glb":
        mesh.apply_transform(_Z_UP)
    return mesh


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
