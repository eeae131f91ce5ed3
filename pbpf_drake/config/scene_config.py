"""A scene: models, camera, topics and filter configuration in one YAML file.

The same file builds the prediction model, the ray-cast world, the truth
simulation and the picture. No object, robot or number of a scene is known to
the package.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.common.schema import Transform
from pydrake.common.yaml import yaml_dump, yaml_load, yaml_load_typed
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import ModelDirective

from pbpf_drake.config.log_topics import PRESETS, LogTopics
from pbpf_drake.config.particle_filter_config import (
    ParticleFilterConfig,
    VisibilityConfig,
)
from pbpf_drake.config.recording_config import RecordingConfig
from pbpf_drake.config.symmetry import SymmetryConfig


@dataclass(kw_only=True)
class CameraConfig:
    """A pinhole camera without distortion, fixed in the world."""

    # The pose in the world of the optical frame C: z points forward, x to the
    # right and y down in the image.
    X_WC: Transform = field(default_factory=Transform)
    # Size of the image (in pixels).
    width: int = 640
    height: int = 480
    # Focal lengths and principal point (in pixels).
    fx: float = 605.904
    fy: float = 604.460
    cx: float = 311.145
    cy: float = 255.473

    def pose(self) -> RigidTransform:
        """Returns X_WC."""
        return self.X_WC.GetDeterministicValue()


@dataclass(kw_only=True)
class TrackedObject:
    """What the filter has to know of one tracked model."""

    # The class name under which the detector reports it; empty means the
    # name of the model.
    class_id: str = ""
    # The name under which the ground truth knows it; empty means the name of
    # the model.
    ground_truth_id: str = ""
    # The visibility thresholds (Section 4.3).
    visibility: VisibilityConfig = field(default_factory=VisibilityConfig)
    # Which turns of it look alike. The filter doesn't know; errors may.
    symmetry: SymmetryConfig = field(default_factory=SymmetryConfig)


@dataclass(kw_only=True)
class Scene:
    """Everything that one YAML file says of a scene."""

    # What there is: Drake's model directives. Files are found through
    # package://pbpf_drake (this project's models), package://scene (the
    # folder of the scene file), and the packages in ROS_PACKAGE_PATH.
    directives: list[ModelDirective] = field(default_factory=list)
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


def LoadScene(filename: str | Path) -> Scene:
    """Loads a scene file and checks what can be checked without its models.

    Args:
        filename: the YAML file.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: the file isn't a scene; the message names file and field.
    """
    path = Path(filename).expanduser().resolve()
    if not path.is_file():
        raise FileNotFoundError(f"There is no scene file {path}")
    try:
        scene = yaml_load_typed(
            schema=Scene, filename=str(path), defaults=_defaults(path)
        )
    except Exception as error:
        where = ": ".join(filter(None, (str(path), _bad_field(path))))
        raise ValueError(f"Scene file {where}: {error}") from error
    scene.path = str(path)
    try:
        _validate(scene)
    except ValueError as error:
        raise ValueError(f"Scene file {path}: {error}") from error
    return scene


def _defaults(path: Path) -> Scene:
    """Returns what fields are that the file leaves out."""
    data = yaml_load(filename=str(path))
    topics = data.get("topics") if isinstance(data, dict) else None
    preset = topics.get("preset") if isinstance(topics, dict) else None
    # One that is unknown is refused when the scene is checked.
    make = PRESETS.get(preset) if isinstance(preset, str) else None
    return Scene(topics=make()) if make else Scene()


def _bad_field(path: Path) -> str:
    """Returns what Drake's own messages lack: the field that is wrong."""
    try:
        data = yaml_load(filename=str(path))
    except Exception:  # It isn't YAML; the message says where.
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


def _validate(scene: Scene) -> None:
    if not scene.directives:
        raise ValueError("directives is empty; expected at least one model")
    if not scene.robot:
        raise ValueError("robot is empty; expected the name of a model")
    if not scene.tracked:
        raise ValueError("tracked is empty; expected at least one model")
    if scene.robot in scene.tracked:
        raise ValueError(
            f"tracked contains {scene.robot!r}, which is the robot; expected "
            "models that the robot's model does not contain"
        )
    if len(scene.object_by_class()) != len(scene.tracked):
        raise ValueError(
            "tracked: two models have the same class_id; they are "
            f"{[o.class_id or name for name, o in scene.tracked.items()]}"
        )
    camera = scene.camera
    for name in ("width", "height", "fx", "fy", "cx", "cy"):
        value = getattr(camera, name)
        if not np.isfinite(value):
            raise ValueError(f"camera.{name} is {value}; expected a number")
        if name not in ("cx", "cy") and value <= 0:
            raise ValueError(f"camera.{name} is {value}; expected more than 0")
    if camera.X_WC.base_frame:
        raise ValueError(
            f"camera.X_WC.base_frame is {camera.X_WC.base_frame!r}; expected "
            "none: the pose is in the world"
        )
    if not camera.X_WC.IsDeterministic():
        raise ValueError("camera.X_WC is random; expected one pose")
    if not np.all(np.isfinite(camera.pose().GetAsMatrix4())):
        raise ValueError("camera.X_WC is not finite")
    for name, tracked in scene.tracked.items():
        tracked.visibility.ValidateOrThrow(f"tracked.{name}.visibility")
        tracked.symmetry.ValidateOrThrow(f"tracked.{name}.symmetry")
    for part in ("topics", "filter"):
        try:
            getattr(scene, part).ValidateOrThrow()
        except ValueError as error:
            raise ValueError(f"{part}.{error}") from error
