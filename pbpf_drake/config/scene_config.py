"""A scene: models, camera, topics and filter configuration in one YAML file.

The filter's physics, its ray casting, the simulated truth and all pictures come
from the same file. The package itself knows no object, robot or number of any
scene.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydrake.common.yaml import yaml_dump, yaml_load, yaml_load_typed
from pydrake.multibody.parsing import ModelDirective

from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.config.config_checks import one_line
from pbpf_drake.config.log_topics import PRESETS, LogTopics
from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.recording_config import RecordingConfig
from pbpf_drake.config.symmetry import SymmetryConfig
from pbpf_drake.config.visibility_config import VisibilityConfig
from pbpf_drake.config.yaml_checks import CheckYamlFile


@dataclass(kw_only=True)
class TrackedObject:
    """What the filter has to know of one tracked model."""

    # The class name under which the detector reports it; empty means the
    # name of the model.
    class_id: str = ""
    # The name under which the ground truth knows it; empty means the name of
    # the model.
    ground_truth_id: str = ""
    # Thresholds and factors of visibility (Section 4.3).
    visibility: VisibilityConfig = field(default_factory=VisibilityConfig)
    # Which turns of it look alike. Some errors respect that; the filter doesn't
    # know it.
    symmetry: SymmetryConfig = field(default_factory=SymmetryConfig)


@dataclass(kw_only=True)
class Scene:
    """Everything that a YAML file says of a scene."""

    # What there is, as Drake's model directives. Files are found through
    # package://pbpf_drake (this project's models), package://scene (the folder
    # of the scene file), and the packages below, in ROS_PACKAGE_PATH and in
    # AMENT_PREFIX_PATH. Paths are relative to the folder of the scene file.
    directives: list[ModelDirective] = field(default_factory=list)
    # Folders of packages by their names, relative to that of the scene file.
    packages: dict[str, str] = field(default_factory=dict)
    # The model instance that is the robot.
    robot: str = ""
    # The model instances to track, each one free body. Every other model is
    # fixed and known: it must be welded to the world.
    tracked: dict[str, TrackedObject] = field(default_factory=dict)
    camera: CameraConfig = field(default_factory=CameraConfig)
    topics: LogTopics = field(default_factory=LogTopics)
    filter: ParticleFilterConfig = field(default_factory=ParticleFilterConfig)
    # How diagrams/record_scene.py simulates a truth for this scene.
    recording: RecordingConfig = field(default_factory=RecordingConfig)
    # The scene file; set by LoadScene, not read from the file.
    path: str = ""

    def object_names(self) -> list[str]:
        """The tracked models, in the order of all arrays over objects."""
        return list(self.tracked)

    def object_by_class(self) -> dict[str, str]:
        """The model's name by the class name that the detector reports."""
        return {o.class_id or name: name for name, o in self.tracked.items()}

    def ground_truth_ids(self) -> dict[str, str]:
        """The ground truth's name of each object, by the model's name."""
        return {
            name: o.ground_truth_id or name for name, o in self.tracked.items()
        }

    def ValidateOrThrow(self) -> None:
        """Raises ValueError, naming the field, if a value can't be used.

        What needs the models, or only matters to a recording, is checked when
        it is used.
        """
        self._CheckRoles()
        self.camera.ValidateOrThrow("camera")
        for name, tracked in self.tracked.items():
            tracked.visibility.ValidateOrThrow(f"tracked.{name}.visibility")
            tracked.symmetry.ValidateOrThrow(f"tracked.{name}.symmetry")
        for part in ("topics", "filter"):
            try:
                getattr(self, part).ValidateOrThrow()
            except ValueError as error:
                raise ValueError(f"{part}.{error}") from error

    def _CheckRoles(self) -> None:
        if not self.directives:
            raise ValueError("directives is empty; expected at least one model")
        if not self.robot:
            raise ValueError("robot is empty; expected the name of a model")
        if not self.tracked:
            raise ValueError("tracked is empty; expected at least one model")
        if self.robot in self.tracked:
            raise ValueError(
                f"tracked contains {self.robot!r}, which is the robot; "
                "expected models that the robot's model does not contain"
            )
        if len(self.object_by_class()) != len(self.tracked):
            raise ValueError(
                "tracked: two models have the same class_id; they are "
                f"{[o.class_id or name for name, o in self.tracked.items()]}"
            )


def LoadScene(filename: str | Path) -> Scene:
    """Loads a scene file and checks what can be checked without its models.

    Args:
        filename: the YAML file.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: the file isn't a scene; the message names file and field.
    """
    path = Path(filename).expanduser().resolve()
    if not path.exists() or path.is_dir():
        raise FileNotFoundError(f"There is no scene file {path}")
    try:
        CheckYamlFile(path)
    except ValueError as error:
        raise ValueError(f"Scene file {path}: {error}") from error
    try:
        scene = yaml_load_typed(
            schema=Scene, filename=str(path), defaults=_defaults(path)
        )
    except Exception as error:
        where = ": ".join(filter(None, (str(path), _bad_field(path))))
        raise ValueError(f"Scene file {where}: {one_line(error)}") from error
    scene.path = str(path)
    try:
        scene.ValidateOrThrow()
    except ValueError as error:
        raise ValueError(f"Scene file {path}: {error}") from error
    return scene


def _defaults(path: Path) -> Scene:
    """Returns a scene with the values that fields have if left out."""
    data = yaml_load(filename=str(path))
    topics = data.get("topics") if isinstance(data, dict) else None
    preset = topics.get("preset") if isinstance(topics, dict) else None
    # An unknown preset is refused later, when the scene is checked.
    make = PRESETS.get(preset) if isinstance(preset, str) else None
    return Scene(topics=make()) if make else Scene()


def _bad_field(path: Path) -> str:
    """Returns the name of the field that is wrong: Drake's messages lack it."""
    try:
        data = yaml_load(filename=str(path))
    except Exception:  # It isn't YAML at all; Drake's message says where.
        return ""
    names: list[str] = []
    while isinstance(data, dict) and "_tag" not in data:
        bad = [name for name in data if not _fits([*names, name], data[name])]
        if not bad:
            break
        names.append(bad[0])
        data = data[bad[0]]
    return ".".join(names)


def _fits(names: list[str], value: Any) -> bool:
    """Tells if one field of a scene can be loaded on its own."""
    for name in reversed(names):
        value = {name: value}
    try:
        yaml_load_typed(schema=Scene, data=yaml_dump(value))
    except Exception:
        return False
    return True
