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
import os
from pathlib import Path
import shutil
import tempfile

# How the names of mesh files end that Drake reads itself, and that are turned
# into an OBJ file first.
DRAKE_ENDINGS = (".obj", ".gltf", ".vtk")
CONVERTED_ENDINGS = (".stl", ".dae", ".ply", ".off", ".glb")
# Part of the names in the cache: it changes with what is made of a mesh.
_VERSION = "1"


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
        # What reads meshes takes half a second to import, and is seldom needed.
        from pbpf_drake.scene.mesh_conversion import ConvertMesh

        WriteWhole(cached, ConvertMesh(path, data, hull=hull))
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
    """Writes a file so that nobody ever sees a part of it.

    Raises:
        OSError: it can't be written.
    """
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        part = Path(folder) / path.name
        part.write_text(text, encoding="utf-8")
        os.replace(part, path)


@functools.cache
def _temporary_folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="pbpf_drake_"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return folder
