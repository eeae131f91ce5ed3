"""Adds the estimator of any method to a diagram."""

from collections.abc import Callable

from pydrake.systems.framework import DiagramBuilder, System

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.filtering.add_particle_filter import AddParticleFilter
from pbpf_drake.filtering.single_snapshot_estimator import (
    SingleSnapshotEstimator,
)
from pbpf_drake.scene.prediction_model import MakePredictionModel


def AddEstimator(
    *,
    builder: DiagramBuilder,
    scene: Scene,
    method: str,
    config: ParticleFilterConfig,
    on_update: Callable[[float], None] | None = None,
) -> System:
    """Adds a particle filter, or the single-snapshot estimator of "dope".

    Args:
        builder: the diagram to add to.
        scene: the robot, the objects and the camera.
        method: "pbpf", "pbpf-v", "cvpf" or "dope".
        config: of the particle filter, as from ConfigForMethod; of "dope"
            only the period counts.
        on_update: called after each update with its wall time (in seconds).

    Raises:
        ValueError: a model doesn't fit its role, or a field of the config is
            out of range.
    """
    if method != "dope":
        return AddParticleFilter(
            builder=builder, scene=scene, config=config, on_update=on_update
        )
    return builder.AddNamedSystem(
        "single_snapshot_estimator",
        SingleSnapshotEstimator(
            object_names=scene.object_names(),
            nominal_poses=MakePredictionModel(scene).nominal_poses,
            period=config.period,
            on_update=on_update,
        ),
    )
