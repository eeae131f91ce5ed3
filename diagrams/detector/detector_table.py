"""Real, reported and simulated statistics side by side."""

from collections.abc import Mapping, Sequence
import itertools

import numpy as np

from pbpf_drake.diagrams.detector.error_statistics import describe_errors
from pbpf_drake.diagrams.paper.paper_values import PAPER

COLUMNS = (
    "scene",
    "object",
    "statistic",
    "real_trace",
    "paper",
    "simulated_05",
    "simulated_50",
    "simulated_95",
)
_QUANTILES = (0.05, 0.5, 0.95)


def make_statistic_rows(
    scene: str,
    object_name: str,
    simulated: Sequence[Mapping[str, float]],
    trace: np.ndarray | None,
) -> list[list[str]]:
    """Returns a row of COLUMNS per statistic; a cell is empty if unknown.

    Args:
        scene, object_name: their names.
        simulated: the statistics of each run and draw; at least one.
        trace: (N, 2) errors of a real run [m, rad], if there is one.
    """
    real = {} if trace is None else describe_errors(trace)
    paper = PAPER.get((scene, object_name, "dope"))
    means = (
        {"position: mean": paper.pos_mean, "rotation: mean": paper.rot_mean}
        if paper
        else {}
    )
    rows = []
    for key in simulated[0]:
        values = np.array([run[key] for run in simulated])
        values = values[np.isfinite(values)]
        quantiles = (
            np.quantile(values, _QUANTILES) if len(values) else [np.nan] * 3
        )
        numbers = [real.get(key, np.nan), means.get(key, np.nan), *quantiles]
        texts = ["" if np.isnan(x) else f"{x:.4f}" for x in numbers]
        rows.append([scene, object_name, key, *texts])
    return rows


def format_statistics(rows: Sequence[Sequence[str]]) -> str:
    """Returns rows of COLUMNS as text, grouped by scene and object.

    A real number outside of the simulated ones is marked.
    """
    return "\n".join(
        line
        for (scene, object_name), group in itertools.groupby(
            rows, key=lambda row: (row[0], row[1])
        )
        for line in (
            f"\n{scene}, {object_name}",
            f"{'':31}{'real':>8}{'paper':>8}{'simulated: 5, 50, 95 %':>27}",
            *map(_format_row, group),
        )
    )


def _format_row(row: Sequence[str]) -> str:
    _, _, key, real, paper, *simulated = row
    mark = ""
    if real and all(simulated):
        low, high = float(simulated[0]), float(simulated[-1])
        mark = "" if low <= float(real) <= high else "  outside"
    numbers = "".join(f"{x:>9}" for x in simulated)
    return f"  {key:29}{real:>8}{paper:>8}{numbers}{mark}"
