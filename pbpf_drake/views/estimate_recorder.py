"""A system that records a filter's estimates as an MCAP file."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    System,
)

from pbpf_drake.connect_ports import ConnectByName
from pbpf_drake.poses.pose_conversion import pose_array
from pbpf_drake.views.track_mcap import TrackMcap

_OPTIONAL_PORTS = ("covariances", "particles")
_INPUT_PORTS = ("estimated_poses", *_OPTIONAL_PORTS, "update_time")


class EstimateRecorder(LeafSystem):
    """Writes estimates and particles of K objects to an MCAP file.

    .. pydrake_system::

        name: EstimateRecorder
        input_ports:
        - estimated_poses
        - covariances (optional)
        - particles (optional)
        - update_time

    Input ``estimated_poses``: List[RigidTransform] of length K, X_WO.

    Input ``covariances``: (K, 6, 6) flattened row-major: rotation vector
    first, then position, in the world. Zeros are written if it isn't connected.

    Input ``particles``: (M, K, 7) flattened row-major: qw qx qy qz, x y z of
    X_WO (in meters). No particles are written if it isn't connected.

    Input ``update_time``: (1,) time of the estimate (in seconds); negative
    before the first one.

    Events: at every period, and when the diagram is published by force, it
    looks for an estimate that it hasn't written yet. The estimate goes to
    ``/pbpf/estimate/<object>``, as geometry_msgs/PoseWithCovarianceStamped, and
    its particles go to ``/pbpf/particles/<object>``, as
    geometry_msgs/PoseArray. Both are in the frame "world" and are stamped with
    the update time.

    The file is opened at construction and is complete after ``Close``: call it,
    or use the recorder as a context manager. The open file is not part of the
    context, so one recorder serves only one simulation.
    """

    def __init__(
        self,
        *,
        filename: str | Path,
        object_names: Sequence[str],
        num_particles: int,
        period: float,
        offset: float = 0.0,
        start_time: int = 0,
    ):
        """Makes the system and opens the file.

        Args:
            filename: the file to write; its folder must exist.
            object_names: K names of tracked models.
            num_particles: M; 0 for an estimator without particles.
            period: how often to look for a new estimate (in seconds).
            offset: when to look for the first time (in seconds).
            start_time: what times are relative to, since the epoch (in
                nanoseconds).
        """
        super().__init__()
        self._names = tuple(object_names)
        self._particles_shape = (num_particles, len(self._names), 7)
        self._last_update_time = -1.0
        self._DeclareInputPorts()
        self.DeclarePeriodicPublishEvent(
            period_sec=period, offset_sec=offset, publish=self._Publish
        )
        self.DeclareForcedPublishEvent(publish=self._Publish)
        self._file: TrackMcap | None = TrackMcap(
            filename=filename, start_time=start_time
        )

    def _DeclareInputPorts(self) -> None:
        count = len(self._names)
        self.DeclareAbstractInputPort(
            name="estimated_poses",
            model_value=Value([RigidTransform()] * count),
        )
        self.DeclareVectorInputPort(name="covariances", size=36 * count)
        self.DeclareVectorInputPort(
            name="particles", size=int(np.prod(self._particles_shape))
        )
        self.DeclareVectorInputPort(name="update_time", size=1)

    def Close(self) -> None:
        """Completes the file; to publish something later is an error."""
        if self._file is not None:
            self._file.Close()
        self._file = None

    def __enter__(self) -> "EstimateRecorder":
        """Returns the recorder."""
        return self

    def __exit__(self, *exception: object) -> None:
        """Completes the file."""
        self.Close()

    def _Publish(self, context: Context) -> None:
        update_time = self.GetInputPort("update_time").Eval(context)[0]
        if not update_time >= 0 or update_time == self._last_update_time:
            return
        self._last_update_time = update_time
        poses = self.GetInputPort("estimated_poses").Eval(context)
        if len(poses) != len(self._names):
            raise ValueError(
                f"estimated_poses has {len(poses)} poses; expected one for "
                f"each of {list(self._names)}"
            )
        if self._file is None:
            raise RuntimeError("EstimateRecorder is closed; it can't publish")
        covariances = self._Covariances(context)
        particles = self._Particles(context)
        for k, name in enumerate(self._names):
            self._file.WriteEstimate(
                update_time, name, pose_array(poses[k]), covariances[k]
            )
            if particles is not None:
                self._file.WriteParticles(update_time, name, particles[:, k])

    def _Covariances(self, context: Context) -> np.ndarray:
        port = self.GetInputPort("covariances")
        shape = (len(self._names), 6, 6)
        if not port.HasValue(context):
            return np.zeros(shape)
        return port.Eval(context).reshape(shape)

    def _Particles(self, context: Context) -> np.ndarray | None:
        port = self.GetInputPort("particles")
        if not port.HasValue(context):
            return None
        return port.Eval(context).reshape(self._particles_shape)


def AddEstimateRecorder(
    *,
    builder: DiagramBuilder,
    filter: System,
    filename: str | Path,
    object_names: Sequence[str],
    num_particles: int,
    period: float,
    offset: float = 0.0,
    start_time: int = 0,
) -> EstimateRecorder:
    """Adds a recorder and connects it to a filter.

    Args:
        builder: the diagram to add to.
        filter: has output ports with the names of the recorder's inputs; it can
            be without those that are optional.
        filename: see EstimateRecorder, as for all that follow.
        object_names: K names of tracked models.
        num_particles: M; 0 for an estimator without particles.
        period: how often to look for a new estimate (in seconds).
        offset: when to look for the first time (in seconds).
        start_time: what times are relative to (in nanoseconds).

    Returns:
        The recorder, to close after the simulation.
    """
    recorder = EstimateRecorder(
        filename=filename,
        object_names=object_names,
        num_particles=num_particles,
        period=period,
        offset=offset,
        start_time=start_time,
    )
    builder.AddSystem(recorder)
    sources = {
        name: filter.GetOutputPort(name)
        for name in _INPUT_PORTS
        if name not in _OPTIONAL_PORTS or filter.HasOutputPort(name)
    }
    ConnectByName(builder=builder, sources=sources, target=recorder)
    return recorder
