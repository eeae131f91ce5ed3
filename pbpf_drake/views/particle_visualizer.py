"""Shows a tracker at work in Meshcat."""

from collections.abc import Sequence

import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    LeafSystem,
    OutputPort,
    System,
)

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.connect_ports import ConnectByName
from pbpf_drake.dope_measurement import DopeMeasurement, EvalDopeMeasurement
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.views.palette import (
    DETECTION_RGBA,
    ESTIMATE_RGBA,
    TRUTH_RGBA,
)
from pbpf_drake.views.scene_meshcat import SceneMeshcat
from pbpf_drake.views.visual_geometry import (
    DrawGeometries,
    DrawOutline,
    MakeSilhouette,
)

# Particles overlap: one alone can hardly be seen, all together look like a
# cloud.
_PARTICLE_OPACITY = 0.03
_FILL_OPACITY = 0.25
# More particles than this aren't drawn, or Meshcat gets slow.
_MAX_DRAWN = 70
# A detection that is older than this isn't new any more (in seconds).
_NEW = 0.25


class ParticleVisualizer(LeafSystem):
    """Draws the robot, and where the objects are said to be.

    For each object, Meshcat has ``estimate/NAME``, solid with a green tint;
    ``particles/NAME/m``, faint silhouettes; ``detection/NAME``, the last
    detection as a yellow box, which is filled while the detection is new; and
    ``truth/NAME``, a blue box. An input that isn't connected isn't shown, and
    neither is a pose that isn't finite.

    .. pydrake_system::

        name: ParticleVisualizer
        input_ports:
        - joint_positions
        - estimated_poses
        - particles (optional)
        - dope_measurement (optional)
        - ground_truth_poses (optional)

    Input ``joint_positions``: (n,) in the order of the robot's model.
    Input ``estimated_poses``: List[RigidTransform], X_WO of the K tracked
    objects in the scene's order.
    Input ``particles``: (M, K, 7) flattened row-major; qw qx qy qz, x y z (in
    meters); at most 70 of them, evenly spaced, are drawn.
    Input ``dope_measurement``: a DopeMeasurement.
    Input ``ground_truth_poses``: List[RigidTransform], X_WO of the objects
    in ``ground_truth_names``.

    Events: publishes every ``period``, for the first time at ``offset``. If a
    filter with the same period updates at a time, only what is published after
    that time shows it: hence the offset is a little above zero.
    """

    def __init__(
        self,
        *,
        meshcat: Meshcat,
        scene: Scene,
        num_particles: int = 0,
        ground_truth_names: Sequence[str] | None = None,
        period: float = 0.16,
        offset: float = 0.001,
    ):
        """Draws the scene and declares the ports.

        Args:
            meshcat: where to draw.
            scene: what to draw.
            num_particles: M; 0 for an estimator without particles.
            ground_truth_names: the objects that ground_truth_poses has; by
                default all that are tracked.
            period: time between two pictures (in seconds).
            offset: time of the first picture (in seconds).
        """
        super().__init__()
        self._meshcat = meshcat
        self._scene = SceneMeshcat(meshcat=meshcat, scene=scene)
        self._names = self._scene.object_names
        self._truth_names = tuple(
            self._names if ground_truth_names is None else ground_truth_names
        )
        drawn = min(num_particles, _MAX_DRAWN)
        self._drawn = np.linspace(0, num_particles - 1, drawn).astype(int)
        self._shape = (num_particles, len(self._names), 7)
        self._Declare(period, offset)
        self._Draw()
        self._scene.SetCameraView()

    def _Declare(self, period: float, offset: float) -> None:
        poses = [RigidTransform()]
        self._joint_positions = self.DeclareVectorInputPort(
            "joint_positions", self._scene.num_positions
        )
        self._estimated_poses = self.DeclareAbstractInputPort(
            "estimated_poses", Value(poses)
        )
        self._particles = self.DeclareVectorInputPort(
            "particles", int(np.prod(self._shape))
        )
        self._dope_measurement = self.DeclareAbstractInputPort(
            "dope_measurement", Value(DopeMeasurement())
        )
        self._ground_truth_poses = self.DeclareAbstractInputPort(
            "ground_truth_poses", Value(poses)
        )
        self.DeclarePeriodicPublishEvent(
            period_sec=period, offset_sec=offset, publish=self._Publish
        )

    def _Draw(self) -> None:
        """Draws all objects, hidden until their poses are known."""
        meshcat = self._meshcat
        for name, own in self._scene.object_geometries.items():
            DrawGeometries(meshcat, f"estimate/{name}", own, tint=ESTIMATE_RGBA)
            faint = MakeSilhouette(own, ESTIMATE_RGBA, _PARTICLE_OPACITY)
            for m in range(len(self._drawn)):
                DrawGeometries(meshcat, f"particles/{name}/{m}", faint)
            for path, color in (
                ("detection", DETECTION_RGBA),
                ("truth", TRUTH_RGBA),
            ):
                DrawOutline(meshcat, f"{path}/{name}/outline", own, color)
                fill = MakeSilhouette(own, color, _FILL_OPACITY)
                DrawGeometries(meshcat, f"{path}/{name}/fill", fill)
            for path in ("estimate", "detection", "truth", "particles"):
                meshcat.SetProperty(f"{path}/{name}", "visible", False)

    def _Publish(self, context: Context) -> None:
        time = context.get_time()
        q = self._joint_positions.Eval(context)
        self._scene.SetJointPositions(q, time=time)
        estimates = self._estimated_poses.Eval(context)
        self._PlaceAll("estimate", self._names, estimates, time)
        if self._ground_truth_poses.HasValue(context):
            truth = self._ground_truth_poses.Eval(context)
            self._PlaceAll("truth", self._truth_names, truth, time)
        if self._particles.HasValue(context):
            particles = self._particles.Eval(context).reshape(self._shape)
            self._PlaceParticles(particles, time)
        if self._dope_measurement.HasValue(context):
            self._PlaceDetections(EvalDopeMeasurement(self, context), time)

    def _PlaceAll(
        self,
        path: str,
        names: Sequence[str],
        poses: Sequence[RigidTransform],
        time: float,
    ) -> None:
        for name, X_WO in zip(names, poses, strict=True):
            self._Place(f"{path}/{name}", X_WO, time)

    def _PlaceParticles(self, particles: np.ndarray, time: float) -> None:
        for k, name in enumerate(self._names):
            self._Show(f"particles/{name}", True, time)
            for i, m in enumerate(self._drawn):
                self._meshcat.SetTransform(
                    f"particles/{name}/{i}",
                    rigid_transform(particles[m, k]),
                    time_in_recording=time,
                )

    def _PlaceDetections(
        self, measurement: DopeMeasurement, time: float
    ) -> None:
        for name in self._names:
            detection = measurement.detections.get(name)
            if detection is None:
                self._Show(f"detection/{name}", False, time)
                continue
            self._Place(f"detection/{name}", detection.X_WO, time)
            is_new = time - detection.time <= _NEW
            self._Show(f"detection/{name}/fill", is_new, time)

    def _Place(self, path: str, X_WO: RigidTransform, time: float) -> None:
        finite = bool(np.all(np.isfinite(X_WO.GetAsMatrix34())))
        self._Show(path, finite, time)
        if finite:
            self._meshcat.SetTransform(path, X_WO, time_in_recording=time)

    def _Show(self, path: str, visible: bool, time: float) -> None:
        self._meshcat.SetProperty(
            path, "visible", visible, time_in_recording=time
        )


def _count_particles(filter: System, num_objects: int) -> int:
    """Returns M, or 0 for an estimator without particles."""
    if not filter.HasOutputPort("particles"):
        return 0
    return filter.GetOutputPort("particles").size() // (7 * num_objects)


def AddParticleVisualizer(
    *,
    builder: DiagramBuilder,
    meshcat: Meshcat,
    scene: Scene,
    filter: System,
    joint_positions: OutputPort,
    dope_measurement: OutputPort | None = None,
    ground_truth_poses: OutputPort | None = None,
    ground_truth_names: Sequence[str] | None = None,
) -> ParticleVisualizer:
    """Adds a visualizer, with the period of the scene's filter.

    Args:
        builder: the diagram that ``filter`` is part of.
        meshcat: where to draw.
        scene: what to draw.
        filter: has an output estimated_poses, and may have one for particles.
        joint_positions: the robot's joints.
        dope_measurement: what the detector says.
        ground_truth_poses: List[RigidTransform], where the objects are.
        ground_truth_names: which objects those are; all by default.

    Returns:
        The visualizer, connected to all ports that are given.
    """
    num_particles = _count_particles(filter, len(scene.tracked))
    visualizer = builder.AddSystem(
        ParticleVisualizer(
            meshcat=meshcat,
            scene=scene,
            num_particles=num_particles,
            ground_truth_names=ground_truth_names,
            period=scene.filter.period,
        )
    )
    sources = {
        "joint_positions": joint_positions,
        "estimated_poses": filter.GetOutputPort("estimated_poses"),
        "dope_measurement": dope_measurement,
        "ground_truth_poses": ground_truth_poses,
    }
    if num_particles:
        sources["particles"] = filter.GetOutputPort("particles")
    ConnectByName(
        builder=builder,
        sources={n: port for n, port in sources.items() if port is not None},
        target=visualizer,
    )
    return visualizer
