"""Evaluates PBPF on recorded planar pushes with a simulated blackout.

Every run is tracked with several seeds, by PBPF, by CVPF, and by holding the
last detection. Each seed also draws its own noise of the detections. Between
40 % and 80 % of a run nothing is detected.

The runs are those of mcubelab/cpush, one CSV file each; see
planar_push_log.py for their columns.
"""

from collections.abc import Iterator, Sequence
import itertools
from pathlib import Path
import sys

import numpy as np

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.jobs.scene_run import scene_path
from pbpf_drake.diagrams.recorded_pushes.planar_push_log import ReadPlanarPush
from pbpf_drake.diagrams.recorded_pushes.push_evaluation import (
    COMPARED_METHODS,
    ConfigForPushes,
    PushEvaluation,
    RunEvaluation,
    ThroughMcap,
)
from pbpf_drake.diagrams.recorded_pushes.push_rows import (
    Row,
    choose,
    column,
    distinct,
)
from pbpf_drake.diagrams.tables.text_tables import (
    format_quantiles,
    markdown_line,
)
from pbpf_drake.results.pose_errors import compute_errors
from pbpf_drake.tracking.tracking_diagram import Track

# When nothing is detected, in shares of a run.
_BLACKOUT = (0.4, 0.8)
# The block is found again when the error is below this (in meters).
_RECOVERED = 0.03
# Of the block's height (in meters).
_HALF_HEIGHT = 0.0065
# Neither poked nor frozen during the blackout.
_CLEAN = (
    "StraightLineNoPertubations",
    "StraightLine_2016_10_23_NoPerturbationsBlack",
    "StraightLine_2016_10_23_SinglePerturbations",
    "StraightLine_2016_10_23_StraightLineOpenLoop",
)

# A recording, a seed, and a method.
Job = tuple[Path, int, str]


def evaluate(job: Job) -> Row:
    """Tracks one run with one seed and method; returns a row of results.

    Errors are in meters and radians, ``recovery_s`` is the time from the end
    of the blackout until the error is below 30 mm.
    """
    filename, seed, method = job
    scene = LoadScene(scene_path("planar_push"))
    (name,) = scene.object_names()
    log = ReadPlanarPush(
        filename,
        seed=seed,
        X_WC=scene.camera.pose(),
        height=_HALF_HEIGHT,
        object_name=name,
        blackout=_BLACKOUT,
    )
    log = ThroughMcap(log, scene)
    config = ConfigForPushes(scene, method, seed)
    record = Track(scene=scene, log=log, method=method, config=config)
    errors = compute_errors(record, name, log.ground_truth[name])
    start, end = (share * log.duration for share in _BLACKOUT)
    at_start = np.searchsorted(record.times, start, side="right") - 1
    at_end = np.searchsorted(record.times, end, side="right") - 1
    later = np.flatnonzero(record.times >= end + 1.0)
    found = np.flatnonzero(
        (record.times > end) & (errors.position < _RECOVERED)
    )
    return {
        "run": filename.stem,
        "seed": seed,
        "method": method,
        "start_m": errors.position[at_start],
        "end_m": errors.position[at_end],
        "end_rad": errors.rotation[at_end],
        "mean_m": np.nanmean(errors.position),
        "after_1s_m": errors.position[later[0]] if len(later) else np.nan,
        "recovery_s": record.times[found[0]] - end if len(found) else np.nan,
        "update_ms": float(np.median(record.update_ms)),
    }


def summarize(title: str, rows: Sequence[Row]) -> str:
    """Returns a line of a Markdown table: medians, 90th percentiles."""
    end = {m: 1e3 * column(rows, m, "end_m") for m in COMPARED_METHODS}
    yaw = column(rows, "pbpf", "end_rad")
    share = np.mean(end["pbpf"] <= 0.25 * end["dope"])
    recovery = column(rows, "pbpf", "recovery_s")
    cells = [
        title,
        *(format_quantiles(end[m], 0) for m in COMPARED_METHODS),
        f"{np.median(end['pbpf'] / end['dope']):.2f}",
        f"{np.median(end['pbpf'] / end['cvpf']):.2f}",
        f"{100 * share:.0f} %",
        format_quantiles(yaw, 2),
        f"{1e3 * np.nanmax(column(rows, 'pbpf', 'after_1s_m')):.0f}",
        f"{np.nanmedian(recovery):.2f} / {np.nanmax(recovery):.2f}"
        + (" (some never)" if np.any(np.isnan(recovery)) else ""),
    ]
    return markdown_line(cells)


_HEADER = """\
| run | PBPF [mm] | CVPF [mm] | hold [mm] | PBPF/hold | PBPF/CVPF \
| at most 0.25 hold | rotation [rad] | worst after 1 s [mm] | to 30 mm [s] |
|---|---|---|---|---|---|---|---|---|---|"""


def make_jobs(files: Sequence[Path], num_seeds: int) -> Iterator[Job]:
    """Yields what to evaluate: each run, seed and method."""
    yield from itertools.product(files, range(num_seeds), COMPARED_METHODS)


def make_table(rows: Sequence[Row]) -> Iterator[str]:
    """Yields the lines of a table: one for each run, and for all of them."""
    yield "At the end of the blackout: median / 90th percentile over seeds"
    yield _HEADER
    for run in distinct(rows, "run"):
        yield summarize(run, choose(rows, run=run))
    if clean := [row for row in rows if row["run"] in _CLEAN]:
        yield summarize("**clean runs**", clean)
    yield summarize("**all runs**", rows)


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    evaluation = PushEvaluation(
        name="evaluate_pushes",
        make_jobs=make_jobs,
        evaluate=evaluate,
        make_table=make_table,
        description=__doc__,
        recordings="CSV files",
        pattern="*.csv",
        seeds=5,
        out="real_pushes.csv",
    )
    return RunEvaluation(evaluation, argv)


if __name__ == "__main__":
    sys.exit(main())
