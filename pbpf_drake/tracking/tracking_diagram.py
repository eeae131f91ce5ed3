"""Runs an estimator on a log, in a Drake simulation."""

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from pydrake.common.schema import Transform
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, System

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.connect_ports import ConnectByName
from pbpf_drake.filtering.add_estimator import AddEstimator
from pbpf_drake.filtering.add_particle_filter import ConfigForMethod
from pbpf_drake.log.log_records import Log
from pbpf_drake.poses.pose_conversion import pose_array
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.tracking.add_log_sources import AddLogSources
from pbpf_drake.tracking.add_log_visualizer import AddLogVisualizer


@dataclass
class TrackingDiagram:
    """A log, an estimator, and what watches it.

    Attributes:
        diagram: the whole.
        estimator: its particle filter or single-snapshot estimator.
        update_seconds: the wall times of all updates so far.
    """

    diagram: Diagram
    estimator: System
    update_seconds: list[float] = field(default_factory=list)


class TrackInterrupted(KeyboardInterrupt):
    """Tracking was interrupted after one update or more.

    Attributes:
        record: the updates that were complete by then.
    """

    def __init__(self, record: TrackRecord):
        """Keeps the record."""
        super().__init__()
        self.record = record


def MakeTrackingDiagram(
    *,
    scene: Scene,
    log: Log,
    method: str,
    config: ParticleFilterConfig,
    meshcat: Meshcat | None = None,
) -> TrackingDiagram:
    """Connects the sources of a log to an estimator.

    Args:
        scene: the robot, the objects and the camera.
        log: what was recorded.
        method: "pbpf", "pbpf-v", "cvpf" or "dope".
        config: of the particle filter, as from ConfigForMethod; of "dope"
            only the period counts.
        meshcat: where to draw, if anywhere.

    Raises:
        ValueError: the scene's models don't fit their roles, or a field of
            the config is out of range.
    """
    scene = SceneOfLog(scene, log)
    builder = DiagramBuilder()
    sources = AddLogSources(builder=builder, scene=scene, log=log)
    seconds: list[float] = []
    estimator = AddEstimator(
        builder=builder,
        scene=scene,
        method=method,
        config=config,
        on_update=seconds.append,
    )
    ConnectByName(builder=builder, sources=sources, target=estimator)
    if meshcat is not None:
        AddLogVisualizer(
            builder=builder,
            scene=scene,
            log=log,
            filter=estimator,
            sources=sources,
            meshcat=meshcat,
        )
    return TrackingDiagram(builder.Build(), estimator, seconds)


def Track(
    *,
    scene: Scene,
    log: Log,
    method: str,
    config: ParticleFilterConfig | None = None,
    meshcat: Meshcat | None = None,
    on_step: Callable[[], None] | None = None,
) -> TrackRecord:
    """Tracks the objects of a log and returns all estimates.

    Args:
        scene, log, method: see MakeTrackingDiagram.
        config: of the particle filter; by default the scene's, adapted to
            the method.
        meshcat: see MakeTrackingDiagram.
        on_step: called after each of ``NumSteps``.

    Raises:
        ValueError: the log is shorter than a period, or see
            MakeTrackingDiagram.
        TrackInterrupted: an interruption (KeyboardInterrupt), with what there
            was by then, if there was anything.
    """
    config = config or DefaultConfig(scene, method)
    num_steps = NumSteps(log, config)
    if num_steps < 1:
        raise ValueError(
            f"the log is {log.duration:.3g} s long; expected at least one "
            f"period, {config.period:g} s"
        )
    tracking = MakeTrackingDiagram(
        scene=scene, log=log, method=method, config=config, meshcat=meshcat
    )
    rows: list[dict[str, np.ndarray]] = []
    try:
        for row in _Rows(tracking, config.period, num_steps):
            rows.append(row)
            if on_step:
                on_step()
    except KeyboardInterrupt as error:
        if not rows:
            raise
        seconds = tracking.update_seconds
        record = _MakeRecord(scene, method, config, rows, seconds)
        raise TrackInterrupted(record) from error
    return _MakeRecord(scene, method, config, rows, tracking.update_seconds)


def _Rows(
    tracking: TrackingDiagram, period: float, num_steps: int
) -> Iterator[dict[str, np.ndarray]]:
    """Runs a simulation; yields what the estimator says after each update."""
    simulator = Simulator(tracking.diagram)
    context = tracking.estimator.GetMyContextFromRoot(simulator.get_context())
    simulator.Initialize()
    for step in range(1, num_steps + 1):
        # An update at t is done when the simulator goes on from t.
        simulator.AdvanceTo((step + 0.5) * period)
        yield _ReadPorts(tracking.estimator, context)


def SceneOfLog(scene: Scene, log: Log) -> Scene:
    """Returns the scene with the camera where the log says that it was."""
    if log.X_WC is None:
        return scene
    camera = replace(scene.camera, X_WC=Transform(log.X_WC))
    return replace(scene, camera=camera)


def DefaultConfig(scene: Scene, method: str) -> ParticleFilterConfig:
    """Returns the scene's configuration for a method."""
    if method == "dope":
        return scene.filter
    return ConfigForMethod(scene.filter, method)


def NumSteps(log: Log, config: ParticleFilterConfig) -> int:
    """Returns how many updates there are within the log."""
    return int(log.duration / config.period + 1e-9)


def _ReadPorts(estimator: System, context: Context) -> dict[str, np.ndarray]:
    """Returns the value of every output port, by name."""
    row = {}
    for i in range(estimator.num_output_ports()):
        port = estimator.get_output_port(i)
        row[port.get_name()] = port.Eval(context)
    row["estimated_poses"] = np.array(
        [pose_array(X_WO) for X_WO in row["estimated_poses"]]
    )
    return row


def _MakeRecord(
    scene: Scene,
    method: str,
    config: ParticleFilterConfig,
    rows: list[dict[str, np.ndarray]],
    seconds: list[float],
) -> TrackRecord:
    num_objects = len(scene.tracked)

    def column(name: str, *shape: int) -> np.ndarray:
        """Returns a port's values, or zeros if the estimator lacks it."""
        if rows and name not in rows[0]:
            return np.zeros((len(rows), *shape))
        return np.array([row[name] for row in rows]).reshape(-1, *shape)

    num_particles = len(rows[0].get("weights", ()))
    return TrackRecord(
        method=method,
        object_names=tuple(scene.object_names()),
        times=column("update_time", 1)[:, 0],
        poses=column("estimated_poses", num_objects, 7),
        tracked=column("tracked", num_objects) > 0,
        detected=column("detected", num_objects) > 0,
        covariances=column("covariances", num_objects, 6, 6),
        effective_sample_size=column("effective_sample_size", 1)[:, 0],
        particles=column("particles", num_particles, num_objects, 7),
        weights=column("weights", num_particles),
        particles_used=column("particles_used", 1)[:, 0],
        update_ms=1e3 * np.array(seconds[: len(rows)]),
        period=config.period,
        seed=config.seed,
        config=asdict(config) if num_particles else {"period": config.period},
        detection_counts=np.reshape(
            rows[-1].get("detection_counts", ()), (num_objects, -1)
        )
        if num_particles
        else np.zeros((0, 0)),
        most_rejected=column("num_rejected", num_objects).max(axis=0),
    )
