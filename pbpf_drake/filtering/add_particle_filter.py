"""Makes a particle filter from a scene and adds it to a diagram."""

from collections.abc import Callable
from dataclasses import replace

from pydrake.systems.framework import DiagramBuilder

from pbpf_drake.config.particle_filter_config import (
    METHODS,
    ParticleFilterConfig,
)
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.filtering.particle_filter import PhysicsBasedParticleFilter
from pbpf_drake.filtering.particle_filter_update import ParticleFilterUpdate
from pbpf_drake.motion.motion_model import (
    ConstantVelocityMotionModel,
    MotionModel,
)
from pbpf_drake.motion.physics_motion_model import PhysicsMotionModel
from pbpf_drake.scene.prediction_model import (
    MakePredictionModel,
    PredictionModel,
)
from pbpf_drake.scene.workspace import FindWorkspace
from pbpf_drake.visibility.visibility_model import VisibilityModel

# M of CVPF (Section 6).
_CVPF_PARTICLES = 150


def ConfigForMethod(
    config: ParticleFilterConfig, method: str
) -> ParticleFilterConfig:
    """Returns the config of one of the paper's particle filters.

    Args:
        config: what the methods have in common.
        method: "pbpf", "pbpf-v" or "cvpf". The last has 150 particles, and
            doesn't recover lost tracks: nothing can cut its particles off,
            and a jump would count as velocity.

    Raises:
        ValueError: the method isn't one of them.
    """
    if method == "pbpf":
        return replace(config, motion="physics", use_visibility=False)
    if method == "pbpf-v":
        return replace(config, motion="physics", use_visibility=True)
    if method == "cvpf":
        return replace(
            config,
            motion="constant_velocity",
            use_visibility=False,
            num_particles=_CVPF_PARTICLES,
            recover_lost_tracks=False,
        )
    raise ValueError(
        f"method is {method!r}; expected one of {METHODS[:-1]} "
        "('dope' is no particle filter: see SingleSnapshotEstimator)"
    )


def MakeParticleFilter(
    *,
    scene: Scene,
    config: ParticleFilterConfig | None = None,
    on_update: Callable[[float], None] | None = None,
) -> PhysicsBasedParticleFilter:
    """Makes the filter of a scene.

    Args:
        scene: the robot, the objects and the camera.
        config: the filter's configuration; by default the scene's.
        on_update: called after each update with its wall time (in seconds).

    Raises:
        ValueError: a model doesn't fit its role, or a field of the config is
            out of range.
    """
    config = config or scene.filter
    config.ValidateOrThrow()
    model = MakePredictionModel(scene)
    motion_model: MotionModel = ConstantVelocityMotionModel()
    if config.motion == "physics":
        motion_model = PhysicsMotionModel(model=model, config=config)
    visibility_model = None
    if config.use_visibility:
        visibility_model = VisibilityModel(
            scene=scene, num_rays=config.num_rays
        )
    return AssembleParticleFilter(
        scene=scene,
        config=config,
        model=model,
        motion_model=motion_model,
        visibility_model=visibility_model,
        on_update=on_update,
    )


def AssembleParticleFilter(
    *,
    scene: Scene,
    config: ParticleFilterConfig,
    model: PredictionModel,
    motion_model: MotionModel,
    visibility_model: VisibilityModel | None = None,
    on_update: Callable[[float], None] | None = None,
) -> PhysicsBasedParticleFilter:
    """Makes a filter of models that were made before.

    Args:
        scene: the robot, the objects and the camera.
        config: the filter's configuration.
        model: the prediction model of the scene.
        motion_model: moves the particles.
        visibility_model: makes the filter PBPF-V.
        on_update: called after each update with its wall time (in seconds).
    """
    tracked = scene.tracked.values()
    update = ParticleFilterUpdate(
        config=config,
        motion_model=motion_model,
        visibility_model=visibility_model,
        visibility_configs=tuple(o.visibility for o in tracked),
    )
    return PhysicsBasedParticleFilter(
        config=config,
        update=update,
        object_names=scene.object_names(),
        nominal_poses=model.nominal_poses,
        num_joints=len(model.joint_names),
        on_update=on_update,
        joint_names=model.joint_names,
        bounds=FindWorkspace(model),
    )


def AddParticleFilter(
    *,
    builder: DiagramBuilder,
    scene: Scene,
    config: ParticleFilterConfig | None = None,
    name: str = "particle_filter",
    on_update: Callable[[float], None] | None = None,
) -> PhysicsBasedParticleFilter:
    """Adds the filter of a scene to a diagram; see MakeParticleFilter."""
    return builder.AddNamedSystem(
        name,
        MakeParticleFilter(scene=scene, config=config, on_update=on_update),
    )
