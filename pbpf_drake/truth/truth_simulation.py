"""Simulates the truth of a scene and records it as a log."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.log.log_records import (
    DetectionRecord,
    JointRecord,
    Log,
    PoseRecord,
)
from pbpf_drake.truth.simulated_detector import (
    SimulatedDetector,
)
from pbpf_drake.truth.true_visibility import VisibilityCamera
from pbpf_drake.truth.truth_model import MakeTruth, MakeTruthContext, Truth
from pbpf_drake.truth.truth_parameters import (
    TruthParameters,
    draw_truth_parameters,
)

# When the log begins (in nanoseconds). ROS takes a stamp of 0 for none at all.
_START_TIME = 1_000_000_000

# Records something: called with the time (in seconds) and the truth's context.
_Record = Callable[[float, Context], None]


@dataclass(frozen=True)
class Recording:
    """A simulated run.

    Attributes:
        log: what was recorded.
        parameters: what was drawn for this run.
        image_times: (N,) when the camera's images were taken (in seconds).
        visibility: (N, K) the visible share of each object in each image.
    """

    log: Log
    parameters: TruthParameters
    image_times: np.ndarray
    visibility: np.ndarray


def RecordRun(
    *,
    scene: Scene,
    run: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Simulates a run of a scene as its ``recording`` says.

    Runs differ in where objects start, in the path, in friction and mass, and
    in what the detector gets wrong. The scene, with its ``recording.seed``, and
    the run's number determine all of it.

    Args:
        scene: the scene.
        run: the number of the run, from 0.
        progress: called again and again with the time reached (in seconds).

    Raises:
        ValueError: the run has no such number; ``recording`` has a bad value,
            doesn't fit the scene's models, or its path can't be followed.
    """
    if run < 0:
        raise ValueError(f"run is {run}; expected 0 or more")
    config = scene.recording
    parameters, truth, context = _make_run(scene, run)
    recorder = _Recorder(
        scene=scene, truth=truth, rng=_make_generator(config.seed, run, 1)
    )
    simulator = Simulator(truth.diagram, context)
    periods: dict[_Record, float] = {
        recorder.RecordJoints: config.joint_period,
        recorder.RecordGroundTruth: config.ground_truth_period,
        recorder.RecordDetections: config.detector.period,
    }
    for time, due in _schedule(periods, config.duration, config.time_step):
        simulator.AdvanceTo(time, interruptible=False)
        for record in due:
            record(time, context)
        if progress is not None:
            progress(time)
    return recorder.MakeRecording(parameters)


def _make_run(scene: Scene, run: int) -> tuple[TruthParameters, Truth, Context]:
    """Returns what is drawn for a run, its diagram, and the state at its start.

    Raises:
        ValueError: the scene can't be recorded; the message names its file.
    """
    config = scene.recording
    try:
        config.ValidateOrThrow()
        parameters = draw_truth_parameters(
            config, len(scene.tracked), _make_generator(config.seed, run, 0)
        )
        truth = MakeTruth(scene=scene, parameters=parameters)
        context = MakeTruthContext(truth=truth, parameters=parameters)
    except (ValueError, RuntimeError) as error:
        where = f"Scene {scene.path or '(without a file)'}"
        raise ValueError(f"{where}: {error}") from error
    return parameters, truth, context


def _make_generator(seed: int, run: int, purpose: int) -> np.random.Generator:
    return np.random.default_rng(
        np.random.SeedSequence(seed, spawn_key=(run, purpose))
    )


def _schedule(
    periods: dict[_Record, float], duration: float, time_step: float
) -> Iterator[tuple[float, list[_Record]]]:
    """Yields each time at which something is due, and what is.

    All times are whole numbers of simulation steps, so that a period never
    varies and what is recorded at a time is the state after its step.
    """
    intervals = {
        record: max(1, round(period / time_step))
        for record, period in periods.items()
    }
    last = round(duration / time_step)
    steps = np.unique(
        np.concatenate([np.arange(0, last + 1, n) for n in intervals.values()])
    )
    for step in steps:
        yield (
            float(step * time_step),
            [record for record, n in intervals.items() if step % n == 0],
        )


class _Recorder:
    """Collects what goes into the log while the simulation runs."""

    def __init__(
        self, *, scene: Scene, truth: Truth, rng: np.random.Generator
    ) -> None:
        config, plant = scene.recording, truth.diagram.plant()
        self._truth = truth
        self._names = scene.object_names()
        joints = [plant.get_joint(j) for j in truth.joints]
        self._joint_names = tuple(j.name() for j in joints)
        self._q_rows = [j.position_start() for j in joints]
        self._v_rows = [j.velocity_start() for j in joints]
        self._camera = VisibilityCamera(
            diagram=truth.diagram,
            objects=truth.models.objects,
            camera=scene.camera,
        )
        self._detector = SimulatedDetector(
            config=config.detector,
            names=self._names,
            X_WC=scene.camera.pose(),
            rng=rng,
        )
        self._joints: list[tuple] = []
        self._ground_truth: list[tuple] = []
        self._images: list[tuple] = []
        self._detections: list[DetectionRecord] = []

    def RecordJoints(self, time: float, context: Context) -> None:
        """Keeps the measured joint motion."""
        plant = self._truth.diagram.plant()
        plant_context = self._truth.diagram.plant_context(context)
        q = plant.GetPositions(plant_context)[self._q_rows]
        v = plant.GetVelocities(plant_context)[self._v_rows]
        self._joints.append((time, q, v))

    def RecordGroundTruth(self, time: float, context: Context) -> None:
        """Keeps the true poses of the objects."""
        self._ground_truth.append((time, self._poses(context)))

    def RecordDetections(self, time: float, context: Context) -> None:
        """Takes an image and keeps what is detected in it."""
        plant = self._truth.diagram.plant()
        visibility = self._camera.CalcVisibility(
            plant.GetPositions(self._truth.diagram.plant_context(context))
        )
        self._images.append((time, visibility))
        self._detections += self._detector.Detect(
            time=time, poses=self._poses(context), visibility=visibility
        )

    def MakeRecording(self, parameters: TruthParameters) -> Recording:
        """Returns all that was kept."""
        times, q, v = (np.array(x) for x in zip(*self._joints, strict=True))
        log = Log(
            joints=JointRecord(
                names=self._joint_names, times=times, positions=q, velocities=v
            ),
            detections=tuple(self._detections),
            ground_truth={
                name: self._pose_record(k) for k, name in enumerate(self._names)
            },
            start_time=_START_TIME,
        )
        times, visibility = (
            np.array(x) for x in zip(*self._images, strict=True)
        )
        return Recording(log, parameters, times, visibility)

    def _poses(self, context: Context) -> list[RigidTransform]:
        plant = self._truth.diagram.plant()
        plant_context = self._truth.diagram.plant_context(context)
        return [
            plant.get_body(b).EvalPoseInWorld(plant_context)
            for b in self._truth.models.objects
        ]

    def _pose_record(self, k: int) -> PoseRecord:
        poses = [poses[k] for _, poses in self._ground_truth]
        return PoseRecord(
            times=np.array([time for time, _ in self._ground_truth]),
            q_WO=np.array([X.rotation().ToQuaternion().wxyz() for X in poses]),
            p_WO=np.array([X.translation() for X in poses]),
        )
