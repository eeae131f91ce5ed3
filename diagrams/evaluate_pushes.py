"""Evaluates PBPF on recorded planar pushes with a simulated blackout.

Every run is tracked with several seeds, by PBPF, by CVPF, and by holding the
last detection. Each seed also draws its own noise of the detections. Between
40 % and 80 % of a run nothing is detected.

The runs are those of mcubelab/cpush, one CSV file each; see
planar_push_log.py for their columns.
"""

import argparse
import itertools
from pathlib import Path
import sys

import numpy as np

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.recorded_pushes.planar_push_log import ReadPlanarPush
from pbpf_drake.diagrams.recorded_pushes.push_evaluation import (
    METHODS,
    EvaluateAll,
    PushConfig,
    Row,
    RunEvaluation,
    ThroughMcap,
    WriteRows,
    column,
    spread,
)
from pbpf_drake.results.pose_errors import compute_errors
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.tracking_diagram import Track

_BLACKOUT = (0.4, 0.8)
_RECOVERED = 0.03
_HALF_HEIGHT = 0.0065
# Neither poked nor frozen during the blackout.
_CLEAN = (
    "StraightLineNoPertubations",
    "StraightLine_2016_10_23_NoPerturbationsBlack",
    "StraightLine_2016_10_23_SinglePerturbations",
    "StraightLine_2016_10_23_StraightLineOpenLoop",
)


def evaluate(job: tuple[Path, int, str]) -> Row:
    """Tracks one run with one seed and method; returns a row of results.

    Errors are in meters and radians, ``recovery_s`` is the time from the end
    of the blackout until the error is below 30 mm.
    """
    filename, seed, method = job
    scene = LoadScene(data_folder("diagrams") / "scenes" / "planar_push.yaml")
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
    config = PushConfig(scene, method, seed)
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


def summarize(title: str, rows: list[dict]) -> str:
    """Returns a line of a Markdown table: medians, 90th percentiles."""
    end = {m: 1e3 * column(rows, m, "end_m") for m in METHODS}
    yaw = column(rows, "pbpf", "end_rad")
    share = np.mean(end["pbpf"] <= 0.25 * end["dope"])
    recovery = column(rows, "pbpf", "recovery_s")
    cells = [
        title,
        *(spread(end[m], 0) for m in METHODS),
        f"{np.median(end['pbpf'] / end['dope']):.2f}",
        f"{np.median(end['pbpf'] / end['cvpf']):.2f}",
        f"{100 * share:.0f} %",
        spread(yaw, 2),
        f"{1e3 * np.nanmax(column(rows, 'pbpf', 'after_1s_m')):.0f}",
        f"{np.nanmedian(recovery):.2f} / {np.nanmax(recovery):.2f}"
        + (" (some never)" if np.any(np.isnan(recovery)) else ""),
    ]
    return "| " + " | ".join(cells) + " |"


_HEADER = """\
| run | PBPF [mm] | CVPF [mm] | hold [mm] | PBPF/hold | PBPF/CVPF \
| at most 0.25 hold | rotation [rad] | worst after 1 s [mm] | to 30 mm [s] |
|---|---|---|---|---|---|---|---|---|---|"""


def run(args: argparse.Namespace) -> None:
    """Evaluates all runs in a folder; prints tables, writes all rows."""
    files = sorted(args.data.glob("*.csv"))
    if not files:
        raise ValueError(f"there are no CSV files in {args.data}")
    jobs = itertools.product(files, range(args.seeds), METHODS)
    rows = EvaluateAll(evaluate, jobs, num_processes=args.jobs)
    print("At the end of the blackout: median / 90th percentile over seeds")
    print(_HEADER)
    for path in files:
        of_run = [row for row in rows if row["run"] == path.stem]
        print(summarize(path.stem, of_run))
    clean = [row for row in rows if row["run"] in _CLEAN]
    if clean:
        print(summarize("**clean runs**", clean))
    print(summarize("**all runs**", rows))
    WriteRows(args.out, rows)


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    return RunEvaluation(
        argv,
        run,
        name="evaluate_pushes",
        description=__doc__,
        data="CSV files",
        seeds=5,
        out="real_pushes.csv",
    )


if __name__ == "__main__":
    sys.exit(main())
