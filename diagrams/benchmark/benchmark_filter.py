"""Runs the particle filter on a workload and times its updates by stage.

The filter is the real one. Only its two models are wrapped, so that it is known
when they are called and for how long. The time between two calls belongs to the
stages between them, in the order of ParticleFilterUpdate: resample, predict,
add noise, resolve penetration, weigh by detections, weigh by visibility,
estimate.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.connect_ports import ConnectByName
from pbpf_drake.diagrams.benchmark.benchmark_memory import MemoryInUse
from pbpf_drake.diagrams.benchmark.benchmark_workload import Workload
from pbpf_drake.filtering.add_particle_filter import (
    AssembleParticleFilter,
    ConfigForMethod,
)
from pbpf_drake.filtering.particle_filter import PhysicsBasedParticleFilter
from pbpf_drake.motion.motion_model import MotionInput
from pbpf_drake.motion.physics_motion_model import PhysicsMotionModel
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.tracking.add_log_sources import AddLogSources
from pbpf_drake.tracking.tracking_diagram import NumSteps
from pbpf_drake.visibility.visibility_model import VisibilityModel

# The stages of an update. "Motion" and "penetration" are the motion model's;
# "estimate" is the mean and the new state, "outputs" the evaluation of all
# ports, "total" the update and its outputs.
STAGES = (
    "resampling",
    "motion",
    "noise",
    "penetration",
    "observation",
    "visibility",
    "estimate",
    "outputs",
    "total",
)
# The stage that a model's method is, and the stage before that, which ends when
# the method is called.
_TIMED = {
    "Propagate": "motion",
    "ResolvePenetration": "penetration",
    "Score": "visibility",
}
_BEFORE = {
    "motion": "resampling",
    "penetration": "noise",
    "visibility": "observation",
}
# So many updates at the start of each pass through the log aren't timed: the
# first particles are drawn in them, and memory is allocated.
WARM_UP = 5


@dataclass(frozen=True)
class Call:
    """One call of a model: its stage, and when it was (in seconds)."""

    stage: str
    begin: float
    end: float


@dataclass(frozen=True)
class FilterRun:
    """What was measured of a run of the filter.

    Attributes:
        seconds: by stage, (N,) wall times of N updates.
        passes: inputs of the motion model at these updates, by the passes
            through the log.
        bytes_per_particle: how much memory one more particle took (in bytes).
    """

    seconds: dict[str, np.ndarray]
    passes: list[list[MotionInput]]
    bytes_per_particle: float


class TimedModel:
    """Stands in for a model, and tells when it was called.

    Args:
        model: a MotionModel or a VisibilityModel.
        on_call: called after each call of one of the timed methods, with the
            call and its arguments.
    """

    def __init__(
        self, model: Any, on_call: Callable[[Call, tuple[object, ...]], None]
    ) -> None:
        self._model = model
        self._on_call = on_call

    def __getattr__(self, name: str) -> Any:
        """Returns an attribute of the model; a method of _TIMED is timed."""
        value = getattr(self._model, name)
        if name not in _TIMED:
            return value

        def call(*args: Any, **kwargs: Any) -> Any:
            begin = perf_counter()
            result = value(*args, **kwargs)
            noted = Call(_TIMED[name], begin, perf_counter())
            self._on_call(noted, (*args, *kwargs.values()))
            return result

        return call


class FilterBenchmark:
    """The filter of a workload, with sources that play its log.

    Args:
        workload: scene and log.
        num_particles: M.
        num_threads: that simulate particles.
    """

    def __init__(
        self, workload: Workload, *, num_particles: int, num_threads: int
    ) -> None:
        self.config = replace(
            ConfigForMethod(workload.scene.filter, "pbpf-v"),
            num_particles=num_particles,
            parallelism=num_threads,
        )
        self._calls: list[Call] = []
        self._event = (0.0, 0.0)
        self._motion: MotionInput | None = None
        self._steps = NumSteps(workload.log, self.config)
        builder = DiagramBuilder()
        self._filter = builder.AddSystem(
            _make_filter(
                workload.scene, self.config, self._Note, self._NoteEvent
            )
        )
        sources = AddLogSources(
            builder=builder, scene=workload.scene, log=workload.log
        )
        ConnectByName(builder=builder, sources=sources, target=self._filter)
        self._simulator = Simulator(builder.Build())
        self._start = self._simulator.get_context().Clone()

    def Pass(self) -> Iterator[tuple[dict[str, float], MotionInput]]:
        """Plays the log once, from the filter's first state on.

        Yields:
            Of every update but the first ones: its wall times by stage (in
            seconds), and the input of its motion model.
        """
        context = self._simulator.get_mutable_context()
        context.SetTimeStateAndParametersFrom(self._start)
        self._simulator.Initialize()
        own = self._filter.GetMyContextFromRoot(context)
        for step in range(1, self._steps + 1):
            self._calls.clear()
            # An update at t is done when the simulator goes on from t.
            self._simulator.AdvanceTo((step + 0.5) * self.config.period)
            begin = perf_counter()
            for i in range(self._filter.num_output_ports()):
                self._filter.get_output_port(i).Eval(own)
            outputs = perf_counter() - begin
            if step > WARM_UP:
                assert self._motion is not None
                seconds = split_stages(self._event, self._calls, outputs)
                yield seconds, self._motion

    def _Note(self, call: Call, arguments: tuple[object, ...]) -> None:
        self._calls.append(call)
        motions = [x for x in arguments if isinstance(x, MotionInput)]
        self._motion = motions[0] if motions else self._motion

    def _NoteEvent(self, seconds: float) -> None:
        now = perf_counter()
        self._event = (now - seconds, now)


def split_stages(
    event: tuple[float, float], calls: list[Call], outputs: float
) -> dict[str, float]:
    """Returns the wall time of each of the STAGES (in seconds).

    Args:
        event: begin and end of the update.
        calls: of the models within it, in their order.
        outputs: how long the evaluation of the outputs took.
    """
    seconds = dict.fromkeys(STAGES, 0.0)
    now, end = event
    for call in calls:
        seconds[_BEFORE[call.stage]] += call.begin - now
        seconds[call.stage] += call.end - call.begin
        now = call.end
    seconds["estimate"] += end - now
    seconds["outputs"] = outputs
    seconds["total"] = end - event[0] + outputs
    return seconds


def RunFilter(
    benchmark: FilterBenchmark,
    *,
    num_updates: int,
    on_update: Callable[[], object] = lambda: None,
) -> FilterRun:
    """Times the updates of a filter; the log is played as often as needed."""
    before, grown = MemoryInUse(), 0
    rows: list[dict[str, float]] = []
    passes: list[list[MotionInput]] = []
    while len(rows) < num_updates:
        passes.append([])
        for seconds, motion in benchmark.Pass():
            grown = grown or MemoryInUse() - before
            rows.append(seconds)
            passes[-1].append(motion)
            on_update()
            if len(rows) == num_updates:
                break
    return FilterRun(
        {stage: np.array([row[stage] for row in rows]) for stage in STAGES},
        passes,
        grown / benchmark.config.num_particles,
    )


def _make_filter(
    scene: Scene,
    config: ParticleFilterConfig,
    on_call: Callable[[Call, tuple[object, ...]], None],
    on_update: Callable[[float], None],
) -> PhysicsBasedParticleFilter:
    """Makes the same as MakeParticleFilter, with models that are timed."""
    model = MakePredictionModel(scene)
    motion_model: Any = TimedModel(
        PhysicsMotionModel(model=model, config=config), on_call
    )
    visibility_model: Any = TimedModel(
        VisibilityModel(scene=scene, num_rays=config.num_rays), on_call
    )
    return AssembleParticleFilter(
        scene=scene,
        config=config,
        model=model,
        motion_model=motion_model,
        visibility_model=visibility_model,
        on_update=on_update,
    )
