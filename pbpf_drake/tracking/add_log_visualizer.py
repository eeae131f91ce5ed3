"""Adds a picture of a log, and of what is made of it, to a diagram."""

from collections.abc import Mapping

from pydrake.geometry import Meshcat
from pydrake.systems.framework import DiagramBuilder, OutputPort, System

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.ground_truth_log_source import GroundTruthLogSource
from pbpf_drake.log.log_records import Log
from pbpf_drake.views.particle_visualizer import AddParticleVisualizer


def AddLogVisualizer(
    *,
    builder: DiagramBuilder,
    scene: Scene,
    log: Log,
    filter: System,
    sources: Mapping[str, OutputPort],
    meshcat: Meshcat,
) -> None:
    """Draws all that is known, and the truth of the objects that have one.

    Args:
        builder: the diagram that the other systems are part of.
        scene: what to draw.
        log: has the ground truth, if there is any.
        filter: has an output estimated_poses, and may have one for particles.
        sources: of the log, as from AddLogSources.
        meshcat: where to draw.
    """
    names = [n for n in scene.object_names() if n in log.ground_truth]
    truth = None
    if names:
        truth = builder.AddNamedSystem(
            "ground_truth_log_source",
            GroundTruthLogSource(records=log.ground_truth, object_names=names),
        ).GetOutputPort("ground_truth_poses")
    AddParticleVisualizer(
        builder=builder,
        meshcat=meshcat,
        scene=scene,
        filter=filter,
        **sources,
        ground_truth_poses=truth,
        ground_truth_names=names,
    )
