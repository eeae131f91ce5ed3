"""Scenes to record in tests: the planar pusher with a path of its own."""

from collections.abc import Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant

from pbpf_drake.recording_config import (
    PathConfig,
    Range,
    RecordingConfig,
    Waypoint,
)
from pbpf_drake.scene import LoadScene, Scene
from pbpf_drake.scene_models import data_folder
from pbpf_drake.truth_model import TruthParameters

SCENES = data_folder("diagrams") / "scenes"


def make_planar_scene(
    *,
    duration: float = 0.5,
    seed: int = 0,
    waypoints: Sequence[tuple[float, list[float]]] = (
        (0.0, [0.0, 0.0, 0.0]),
        (0.5, [0.05, 0.0, 0.0]),
    ),
) -> Scene:
    """Returns the planar pusher's scene, with a straight push by default.

    Args:
        duration: of the recording (in seconds).
        seed: of the recording.
        waypoints: time and translation of each.
    """
    scene = LoadScene(SCENES / "planar_push.yaml")
    scene.recording = RecordingConfig(
        duration=duration,
        seed=seed,
        mass_scale=Range(min=1.0, max=1.0),
        stiffness=[20000.0, 20000.0],
        damping=[400.0, 400.0],
        path=PathConfig(
            end_effector="pusher_probe",
            waypoints=[Waypoint(time=t, translation=p) for t, p in waypoints],
        ),
    )
    return scene


def make_parameters(
    scene: Scene, *, friction: float = 0.3, mass_scale: float = 1.0
) -> TruthParameters:
    """Returns given parameters, with starts and waypoints as configured."""
    return TruthParameters(
        mass_scale=np.full(len(scene.tracked), mass_scale),
        friction=friction,
        robot_friction=friction,
        offsets=np.zeros((len(scene.recording.path.waypoints), 3)),
        starts=np.zeros((len(scene.tracked), 3)),
    )


def joint_rows(plant: MultibodyPlant, joints) -> list[int]:
    """Returns where the joints are among all positions."""
    return [plant.get_joint(j).position_start() for j in joints]
