"""The benchmark's measurements as tables and as rows of JSON."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from pbpf_drake.diagrams.benchmark.benchmark_filter import STAGES
from pbpf_drake.diagrams.benchmark.benchmark_reference import PredictionErrors
from pbpf_drake.diagrams.tables.text_tables import (
    markdown_line,
    markdown_table,
)

# The engine that is this project's own.
OWN = "pbpf"


@dataclass(frozen=True)
class Measurement:
    """What was measured of an engine, or of the filter, in one case.

    Attributes:
        engine: OWN, "pybullet" or "mujoco".
        particles: M.
        objects: K.
        threads: their number, or that of processes.
        seconds: by stage, (N,) wall times of N updates; of other engines
            "motion" only.
        errors: of the engine's predictions with K objects.
        bytes_per_particle: of memory; 0 where that isn't known.
    """

    engine: str
    particles: int
    objects: int
    threads: int
    seconds: dict[str, np.ndarray]
    errors: PredictionErrors
    bytes_per_particle: float = 0.0

    def median(self, stage: str) -> float:
        """Returns the median of a stage (in milliseconds)."""
        return float(1e3 * np.median(self.seconds[stage]))


def json_rows(
    measurements: Iterable[Measurement],
) -> list[dict[str, object]]:
    """Returns a row for every stage of every measurement.

    The errors are the means over the engine's predictions, in millimeters and
    radians; they are the same in all rows of an engine and K.
    """
    return [
        {
            "engine": m.engine,
            "particles": m.particles,
            "objects": m.objects,
            "threads": m.threads,
            "stage": stage,
            "median_ms": m.median(stage),
            "p95_ms": float(1e3 * np.percentile(seconds, 95)),
            "max_ms": float(1e3 * np.max(seconds)),
            "error_mm": float(1e3 * np.mean(m.errors.position)),
            "error_rad": float(np.mean(m.errors.rotation)),
        }
        for m in measurements
        for stage, seconds in m.seconds.items()
    ]


def update_table(measurements: Iterable[Measurement], period: float) -> str:
    """Returns a table of the filter's updates, line by line.

    Args:
        measurements: of the filter.
        period: of its updates (in seconds).
    """
    head = ["M", "K", "threads", *STAGES, "p95", "max"]
    head += ["real-time factor", "MB/particle"]
    return markdown_table(head, [_update_row(m, period) for m in measurements])


def update_line(measurement: Measurement, period: float) -> str:
    """Returns the line of one measurement in update_table."""
    return markdown_line(_update_row(measurement, period))


def _update_row(m: Measurement, period: float) -> list[str]:
    total = 1e3 * m.seconds["total"]
    return [
        *map(str, (m.particles, m.objects, m.threads)),
        *(f"{m.median(stage):.2f}" for stage in STAGES),
        f"{np.percentile(total, 95):.2f}",
        f"{np.max(total):.2f}",
        f"{1e3 * period / np.median(total):.2f}",
        f"{m.bytes_per_particle / 1e6:.2f}",
    ]


def growth_table(
    measurements: Sequence[Measurement], process_speedup: float
) -> str:
    """Returns a table of how the time of an update grows with M, K, threads.

    Each ratio is to the smallest M, K or number of threads that was measured.

    Args:
        measurements: of the filter.
        process_speedup: of independent processes, as many as the largest
            number of threads.
    """
    total = {
        (m.particles, m.objects, m.threads): m.median("total")
        for m in measurements
    }
    least = [min(case[i] for case in total) for i in range(3)]
    most = max(threads for _, _, threads in total)
    rows = []
    for (m, k, threads), time in total.items():
        speedup = total[m, k, least[2]] / time
        of_processes = speedup / process_speedup
        is_compared = threads == most > least[2] == 1
        rows.append(
            [
                *(str(x) for x in (m, k, threads)),
                f"{time / m:.3f}",
                f"{time / m / (total[least[0], k, threads] / least[0]):.2f}",
                f"{time / total[m, least[1], threads]:.2f}",
                f"{speedup:.2f}",
                f"{of_processes:.2f}" if is_compared else "-",
            ]
        )
    head = ["M", "K", "threads", "ms/particle"]
    head += [f"over that of M = {least[0]}", f"ms over K = {least[1]}"]
    head += ["speed-up", "of processes'"]
    return markdown_table(head, rows)


def error_table(measurements: Sequence[Measurement]) -> str:
    """Returns a table of the errors of all engines."""
    errors = {(m.engine, m.objects): m.errors for m in measurements}
    rows = [
        [
            engine,
            str(objects),
            f"{1e3 * np.mean(e.position):.3f}",
            f"{1e3 * np.median(e.position):.3f}",
            f"{np.mean(e.rotation):.4f}",
            f"{np.median(e.rotation):.4f}",
        ]
        for (engine, objects), e in errors.items()
    ]
    head = ["engine", "K", "mean [mm]", "median", "mean [rad]", "median"]
    return markdown_table(head, rows)


def engine_table(measurements: Sequence[Measurement]) -> str:
    """Returns a table of the times of all engines, case by case.

    Other engines only predict, so they are compared with the filter's motion
    model. The filter's whole update stands beside it.
    """
    times: dict[tuple[int, int, int], dict[str, float]] = {}
    for m in measurements:
        case = times.setdefault((m.particles, m.objects, m.threads), {})
        case[m.engine] = m.median("motion") / m.particles
        if m.engine == OWN:
            case["update"] = m.median("total") / m.particles
    others = sorted({m.engine for m in measurements} - {OWN})
    rows = []
    for numbers, case in times.items():
        cells = [f"{case['update']:.3f}", f"{case[OWN]:.3f}"]
        for engine in others:
            time = case.get(engine, np.nan)
            ratios = time, time / case[OWN], time / case["update"]
            cells += [f"{x:.3f}" if np.isfinite(x) else "-" for x in ratios]
        rows.append([*map(str, numbers), *cells])
    head = ["M", "K", "threads", "whole update", "motion"]
    for engine in others:
        head += [engine, "over motion", "over update"]
    return markdown_table(head, rows)
