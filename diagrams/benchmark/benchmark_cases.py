"""Measures the filter, its errors and other engines, case by case."""

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
import itertools
import multiprocessing
from typing import ParamSpec, TypeVar

import numpy as np
from tqdm import tqdm

from pbpf_drake.diagrams.benchmark.benchmark_cores import MeasureProcessSpeedup
from pbpf_drake.diagrams.benchmark.benchmark_filter import (
    FilterBenchmark,
    FilterRun,
    RunFilter,
)
from pbpf_drake.diagrams.benchmark.benchmark_reference import (
    PredictionErrors,
    PredictReference,
    PredictSamples,
    Sample,
    compare_predictions,
    make_samples,
    pushed_share,
)
from pbpf_drake.diagrams.benchmark.benchmark_table import OWN, Measurement
from pbpf_drake.diagrams.benchmark.benchmark_workload import LoadWorkload
from pbpf_drake.diagrams.benchmark.other_engines import (
    ENGINES,
    MakePeer,
    RunPeer,
)
from pbpf_drake.diagrams.benchmark.pybullet_peer import MAX_WORLDS
from pbpf_drake.motion.motion_model import MotionResult
from pbpf_drake.scene.prediction_model import MakePredictionModel

Arguments = ParamSpec("Arguments")
Output = TypeVar("Output")


@dataclass(frozen=True)
class Case:
    """What is varied. The filter's own threads are processes."""

    particles: int
    objects: int
    threads: int

    def __str__(self) -> str:
        """Returns it as a title."""
        return f"M={self.particles} K={self.objects} threads={self.threads}"


@dataclass(frozen=True)
class BenchmarkOptions:
    """What to measure.

    Attributes:
        particles, objects, threads: the numbers of each; every combination
            is a case.
        updates: how many are timed per case.
        samples: of how many updates the predictions are compared.
        peers: whether other engines are measured too.
    """

    particles: Sequence[int]
    objects: Sequence[int]
    threads: Sequence[int]
    updates: int
    samples: int
    peers: bool


@dataclass(frozen=True)
class _Reference:
    """What predictions of K objects are compared with."""

    samples: list[Sample]
    results: list[MotionResult]


class Benchmark:
    """Measures all cases.

    Attributes:
        measurements: in the order of the cases.
        speedups: how much faster independent processes are than one, as many
            of them as the most threads; empty with one thread.
        notes: sentences to print.
    """

    def __init__(
        self,
        options: BenchmarkOptions,
        *,
        on_measured: Callable[[Measurement], None] = lambda _: None,
    ) -> None:
        """Takes what to measure; Run does it.

        Args:
            options: what to measure.
            on_measured: called with each measurement.
        """
        self._options = options
        self._on_measured = on_measured
        # By engine and K, and by K.
        self._errors: dict[tuple[str, int], PredictionErrors] = {}
        self._references: dict[int, _Reference] = {}
        self.measurements: list[Measurement] = []
        self.speedups: list[float] = []
        self.notes: list[str] = []

    def Run(self) -> None:
        """Measures all cases, and writes what it finds into the attributes."""
        particles, objects, threads = (
            sorted(set(values))
            for values in (
                self._options.particles,
                self._options.objects,
                self._options.threads,
            )
        )
        for k in objects:
            if threads[-1] > 1:
                self.speedups.append(MeasureProcessSpeedup(threads[-1]))
            for m, n in itertools.product(particles, threads):
                self._Measure(Case(m, k, n))

    def _Measure(self, case: Case) -> None:
        options = self._options
        is_first = case.objects not in self._references
        keep_inputs = is_first or options.peers
        run = _in_new_process(_run_filter, case, options.updates, keep_inputs)
        if is_first:
            self._Compare(case, run)
        self._Add(OWN, case, run.seconds, run.bytes_per_particle)
        for engine in ENGINES if options.peers else ():
            if engine == "pybullet" and case.particles > MAX_WORLDS:
                self.notes.append(
                    f"PyBullet is left out at M = {case.particles}: more than "
                    f"{MAX_WORLDS} worlds take too much memory."
                )
            else:
                self._MeasurePeer(engine, case, run)

    def _Compare(self, case: Case, run: FilterRun) -> None:
        """Computes the reference for K objects, and the filter's errors."""
        scene = LoadWorkload(case.objects).scene
        config = replace(scene.filter, parallelism=max(self._options.threads))
        samples = make_samples(
            list(itertools.chain(*run.passes)),
            config.physics,
            self._options.samples,
        )
        model = MakePredictionModel(scene)
        reference, own = (
            list(
                tqdm(
                    predict(model=model, config=config, samples=samples),
                    total=len(samples),
                    desc=f"errors K={case.objects}",
                    leave=False,
                )
            )
            for predict in (PredictReference, PredictSamples)
        )
        self._references[case.objects] = _Reference(samples, reference)
        self._errors[OWN, case.objects] = compare_predictions(
            [result.poses for result in own], reference
        )
        share = pushed_share(samples, reference)
        self.notes.append(
            f"K = {case.objects}: {share:.0%} of the particles' objects are "
            "moved in an update."
        )

    def _MeasurePeer(self, engine: str, case: Case, run: FilterRun) -> None:
        scene = LoadWorkload(case.objects).scene
        reference = self._references[case.objects]
        key = (engine, case.objects)
        peer = MakePeer(
            engine,
            scene,
            num_particles=case.particles,
            num_threads=case.threads,
        )
        try:
            with _bar(self._options.updates, f"{engine} {case}") as bar:
                seconds, poses = RunPeer(
                    peer,
                    passes=run.passes,
                    samples=[] if key in self._errors else reference.samples,
                    physics=scene.filter.physics,
                    on_update=bar.update,
                )
        finally:
            peer.Close()
        if key not in self._errors:
            self._errors[key] = compare_predictions(poses, reference.results)
        self._Add(engine, case, {"motion": seconds})

    def _Add(
        self,
        engine: str,
        case: Case,
        seconds: dict[str, np.ndarray],
        bytes_per_particle: float = 0.0,
    ) -> None:
        measurement = Measurement(
            engine=engine,
            particles=case.particles,
            objects=case.objects,
            threads=case.threads,
            seconds=seconds,
            errors=self._errors[engine, case.objects],
            bytes_per_particle=bytes_per_particle,
        )
        self.measurements.append(measurement)
        self._on_measured(measurement)


def _run_filter(case: Case, num_updates: int, keep_inputs: bool) -> FilterRun:
    """Times the filter; called in a process of its own."""
    benchmark = MakeFilterBenchmark(case)
    with _bar(num_updates, f"{OWN} {case}") as bar:
        run = RunFilter(
            benchmark, num_updates=num_updates, on_update=bar.update
        )
    return run if keep_inputs else replace(run, passes=[])


def MakeFilterBenchmark(case: Case) -> FilterBenchmark:
    """Returns the filter of a case with its workload."""
    return FilterBenchmark(
        LoadWorkload(case.objects),
        num_particles=case.particles,
        num_threads=case.threads,
    )


def _bar(total: int, title: str) -> tqdm:
    return tqdm(total=total, desc=title, unit="update", leave=False)


def _in_new_process(
    function: Callable[Arguments, Output],
    *args: Arguments.args,
    **kwargs: Arguments.kwargs,
) -> Output:
    """Calls a function in a process of its own; returns what it returns.

    In this process, memory that earlier cases have freed would be used again,
    so that nobody could see how much this case needs.
    """
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        return pool.submit(function, *args, **kwargs).result()
