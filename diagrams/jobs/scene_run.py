"""The name of a scene, and of one simulated run of it."""

from dataclasses import dataclass
from pathlib import Path

from pbpf_drake.scene.scene_models import data_folder


@dataclass(frozen=True)
class SceneRun:
    """One simulated run of a scene.

    Attributes:
        scene: the name of a scene of this package, or the path of a file.
        run: its number, which decides on all that differs between runs.
        duration: of the log (in seconds); None is the scene's.
    """

    scene: str
    run: int
    duration: float | None = None

    def name(self) -> str:
        """Returns what to call it, in a file's name as well."""
        return f"{scene_name(self.scene)}-run_{self.run}"


def scene_name(scene: str) -> str:
    """Returns the name of a scene, from its name or its file's path."""
    return Path(scene).stem


def scene_path(scene: str) -> Path:
    """Returns the file of a scene of this package, or the path as it is."""
    shipped = data_folder("diagrams") / "scenes" / f"{scene}.yaml"
    return shipped if shipped.is_file() else Path(scene)
