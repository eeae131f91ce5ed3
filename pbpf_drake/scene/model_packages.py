"""Where the files are that a scene and its models name.

They are named as in ROS (package://arm_description/meshes/base.stl), as in
Gazebo (model://arm/base.stl), as file:// URLs, or as paths.
"""

import os
from pathlib import Path
from urllib.parse import unquote
import xml.etree.ElementTree as ElementTree

from pydrake.multibody.parsing import PackageMap

from pbpf_drake.config.scene_config import Scene


def AddScenePackages(packages: PackageMap, scene: Scene) -> None:
    """Adds the folder of the scene file as "scene", and its ``packages``.

    Raises:
        ValueError: one of ``packages`` names no folder, or is called as a
            package that there is already.
    """
    home = SceneFolder(scene)
    if scene.path:
        packages.Add("scene", str(home))
    for name, value in scene.packages.items():
        folder = home / Path(value).expanduser()
        if packages.Contains(name) or not folder.is_dir():
            taken = packages.GetPackageNames()
            raise ValueError(
                f"packages.{name} is {value!r}; expected a folder that exists, "
                f"relative to {home}, and a name that is none of {taken}"
            )
        packages.Add(name, str(folder.resolve()))


def AddAmentPackages(packages: PackageMap) -> None:
    """Adds the folders in share of AMENT_PREFIX_PATH: ROS 2's packages.

    Where two are called the same, the first counts.
    """
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    for prefix in filter(None, prefixes):
        for folder in sorted(Path(prefix).glob("share/*/")):
            if not packages.Contains(folder.name):
                packages.Add(folder.name, str(folder))


def SceneFolder(scene: Scene) -> Path:
    """Returns the folder of the scene file; without one, the current folder."""
    return Path(scene.path).parent if scene.path else Path.cwd()


def ResolveModelUrl(url: str, folder: Path, packages: PackageMap) -> Path:
    """Returns the file or folder that a URL or a path leads to; it exists.

    A package that is not in the map is looked for where the naming file is (in
    the folders above it, and beside these), and, without a package.xml, in
    ROS_PACKAGE_PATH.

    Args:
        url: package://, model:// or file://, or a path.
        folder: that of the file with the URL, which relative paths start at.
        packages: the packages that are known.

    Raises:
        ValueError: nothing is there; the message says where was looked, and
            what to do.
    """
    scheme, found, rest = url.partition("://")
    if not found:
        path = folder / Path(url.removeprefix("file:")).expanduser()
    elif scheme in ("package", "model"):
        path = _in_package(url, folder, packages)
    elif scheme == "file":
        path = folder / rest
        if not path.exists():
            path = folder / unquote(rest)
    else:
        raise ValueError(
            f"URI {url!r} begins with {scheme}://; expected package://, "
            "model://, file:// or a path: download what is elsewhere"
        )
    if not path.exists():
        raise ValueError(
            f"URI {url!r} resolved to '{path}' which does not exist; expected "
            "a file, package://scene/... for one in the folder of the scene "
            f"file, or a path from {folder}"
        )
    return path


def _in_package(url: str, folder: Path, packages: PackageMap) -> Path:
    name, _, inside = url.partition("://")[2].partition("/")
    if packages.Contains(name):
        return Path(packages.GetPath(name)) / inside
    listed = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    for above in (folder, *folder.parents, *map(Path, filter(None, listed))):
        for root in (above, above / name):
            if _is_package(root, name) and (root / inside).exists():
                return root / inside
    raise ValueError(
        f"URI {url!r} refers to unknown package {name!r}; name its folder in "
        f"the scene file ('packages: {{{name}: folder}}') or in "
        "ROS_PACKAGE_PATH, or its workspace in AMENT_PREFIX_PATH, or put its "
        "files beside the scene file and write package://scene/..."
    )


def _is_package(root: Path, name: str) -> bool:
    """Tells whether a folder is the package: it is called so, or says so."""
    if root.name == name:
        return root.is_dir()
    try:
        found = ElementTree.parse(root / "package.xml").findtext("name", "")
    except (OSError, ElementTree.ParseError):
        return False
    return found.strip() == name
