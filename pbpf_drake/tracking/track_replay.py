"""Makes the replay of a run, in Meshcat."""

from pathlib import Path

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    LeafSystem,
)

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.log_records import Log
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.tracking.add_log_sources import AddLogSources
from pbpf_drake.tracking.add_log_visualizer import AddLogVisualizer
from pbpf_drake.tracking.tracking_diagram import SceneOfLog
from pbpf_drake.views.local_meshcat import ShortLivedMeshcat
from pbpf_drake.views.scene_meshcat import SaveReplay


class TrackRecordSource(LeafSystem):
    """Plays a run: has the outputs of the estimator, by its record.

    .. pydrake_system::

        name: TrackRecordSource
        output_ports:
        - estimated_poses
        - particles

    Output ``estimated_poses``: List[RigidTransform], X_WO of the K objects.
    Output ``particles``: (M, K, 7) flattened row-major, see
    PhysicsBasedParticleFilter; only if the record has particles.

    Both are those of the last update; before the first one, the poses that the
    scene gives the objects.
    """

    def __init__(self, *, record: TrackRecord, nominal_poses: np.ndarray):
        """Declares the ports.

        Args:
            record: what to play.
            nominal_poses: (K, 7) where the scene has the objects.
        """
        super().__init__()
        self._times = record.times
        self._poses = np.concatenate([nominal_poses[None], record.poses])
        self.DeclareAbstractOutputPort(
            "estimated_poses",
            lambda: Value([RigidTransform()]),
            self._CalcEstimatedPoses,
        )
        _, M, K, _ = record.particles.shape
        if M:
            first = np.broadcast_to(nominal_poses, (1, M, K, 7))
            self._particles = np.concatenate([first, record.particles])
            self.DeclareVectorOutputPort(
                "particles", M * K * 7, self._CalcParticles
            )

    def _CalcEstimatedPoses(self, context: Context, output: Value) -> None:
        poses = self._poses[self._Index(context)]
        output.set_value([rigid_transform(pose) for pose in poses])

    def _CalcParticles(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._particles[self._Index(context)].ravel())

    def _Index(self, context: Context) -> int:
        return int(np.searchsorted(self._times, context.get_time(), "right"))


def WriteReplay(
    *, scene: Scene, log: Log, record: TrackRecord, filename: str | Path
) -> None:
    """Writes a run as one HTML file, which a browser plays without a server.

    Drake's Meshcat can't do without a web server. There is one while the file
    is written, for this machine only, and none after that.

    Args:
        scene: of the log.
        log: what was tracked.
        record: the run.
        filename: the file to write; its folder must exist.

    Raises:
        OSError: there is no port for the server, or the file can't be written.
    """
    with ShortLivedMeshcat() as meshcat:
        meshcat.StartRecording(set_visualizations_while_recording=False)
        _draw(SceneOfLog(scene, log), log, record, meshcat)
        SaveReplay(meshcat, filename)


def _draw(
    scene: Scene, log: Log, record: TrackRecord, meshcat: Meshcat
) -> None:
    """Draws all updates of a run."""
    builder = DiagramBuilder()
    sources = AddLogSources(builder=builder, scene=scene, log=log)
    source = builder.AddNamedSystem(
        "track_record_source",
        TrackRecordSource(
            record=record,
            nominal_poses=MakePredictionModel(scene).nominal_poses,
        ),
    )
    AddLogVisualizer(
        builder=builder,
        scene=scene,
        log=log,
        filter=source,
        sources=sources,
        meshcat=meshcat,
    )
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(float(record.times[-1]) + 0.5 * record.period)
