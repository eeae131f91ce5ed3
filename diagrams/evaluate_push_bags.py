"""Evaluates PBPF on pushes recorded as ROS 1 bags, with short blackouts.

In each recording an arm pushes a block, which turns and slips off the probe.
The probe's motion and the truth are the bag's; detections are the truth with
noise at 15 Hz, see planar_push_log.py, except during a blackout of 0.5 s. There
is one run for each of three blackouts, every seed and every method:

- contact: it ends at the last update at least 0.1 s before the block slips off
- earlier: the half second before that one
- slip: it ends at the first update at least 0.25 s after the block slips off

The bags are those of mcubelab/cpush.
"""

import argparse
from dataclasses import replace
from functools import cache
import itertools
from pathlib import Path
import sys

import numpy as np

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.recorded_pushes.planar_push_log import (
    SimulateDetections,
)
from pbpf_drake.diagrams.recorded_pushes.push_evaluation import (
    METHODS,
    EvaluateAll,
    PushConfig,
    Row,
    RunEvaluation,
    WriteRows,
    column,
    spread,
)
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.log.pose_interpolation import interpolate_poses
from pbpf_drake.poses.quaternions import conjugate, rotate
from pbpf_drake.results.pose_errors import compute_errors
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.tracking_diagram import Track

_BLACKOUTS = ("contact", "earlier", "slip")
_LENGTH = 0.5
_JOINTS = ("pusher_x", "pusher_y")
# Of the block's sides, and from the probe's axis to them in contact: its radius
# and what calibration and the delay of motion capture make of it (in meters).
_HALF_SIDE = 0.049475
_TOUCH = 0.004745 + 0.002


@cache
def _scene() -> Scene:
    return LoadScene(
        data_folder("diagrams") / "scenes" / "planar_push_bag.yaml"
    )


def contact_interval(log: Log, name: str) -> tuple[float, float]:
    """Returns from when to when the probe pushes the block (in seconds).

    It starts when the probe starts to move and ends when the probe is last
    beside the block.
    """
    probe = log.joints.positions
    q, p = interpolate_poses(log.ground_truth[name], log.joints.times)
    offset = np.column_stack([probe, p[:, 2]]) - p
    beside = np.abs(rotate(conjugate(q), offset)[:, :2]) - _HALF_SIDE
    distance = np.linalg.norm(np.maximum(beside, 0), axis=1)
    moved = np.linalg.norm(probe - probe[0], axis=1) > 0.001
    pushing = log.joints.times[moved & (distance < _TOUCH)]
    return float(pushing[0]), float(pushing[-1])


def choose_blackout(
    which: str, slip: float, period: float
) -> tuple[float, float]:
    """Returns one of the three blackouts (in seconds).

    Args:
        which: its name.
        slip: when the block slips off.
        period: of the filter's updates.
    """
    if which == "slip":
        end = period * np.ceil((slip + 0.25) / period)
    else:
        end = period * np.floor((slip - 0.1) / period)
        end -= _LENGTH * (which == "earlier")
    return end - _LENGTH, end


def evaluate(job: tuple[Path, str, int, str]) -> Row:
    """Tracks one run; returns a row of results.

    Errors are in meters and radians: at the blackout's end, and their means
    while the block is pushed and after it slipped off.
    """
    filename, which, seed, method = job
    scene = _scene()
    (name,) = scene.object_names()
    log = ReadLog(filename=filename, scene=scene, joint_names=_JOINTS)
    truth = log.ground_truth[name]
    config = PushConfig(scene, method, seed)
    start, slip = contact_interval(log, name)
    blackout = choose_blackout(which, slip, config.period)
    detections = SimulateDetections(
        truth,
        duration=log.duration,
        seed=seed,
        X_WC=scene.camera.pose(),
        object_name=name,
        blackout=blackout,
    )
    log = replace(log, detections=detections)
    record = Track(scene=scene, log=log, method=method, config=config)
    errors = compute_errors(record, name, truth)
    at_end = np.searchsorted(record.times, blackout[1] + 1e-6) - 1
    before = (record.times >= start) & (record.times < slip)
    after = record.times >= slip
    _, moved = interpolate_poses(truth, np.array(blackout))
    return {
        "run": filename.stem,
        "blackout": which,
        "seed": seed,
        "method": method,
        "blackout_start_s": blackout[0],
        "slip_s": slip,
        "moved_m": float(np.linalg.norm(moved[1] - moved[0])),
        "end_m": errors.position[at_end],
        "end_rad": errors.rotation[at_end],
        "before_slip_m": np.nanmean(errors.position[before]),
        "before_slip_rad": np.nanmean(errors.rotation[before]),
        "after_slip_m": np.nanmean(errors.position[after]),
        "after_slip_rad": np.nanmean(errors.rotation[after]),
    }


_HEADER = """\
| run | blackout | moved [mm] | PBPF [mm] | CVPF [mm] | hold [mm] | PBPF/hold \
| at most 0.35 hold | PBPF [rad] | hold [rad] | before slip [mm] \
| after slip [mm] |
|---|---|---|---|---|---|---|---|---|---|---|---|"""


def summarize(run: str, blackout: str, rows: list[dict]) -> str:
    """Returns a line of a Markdown table: medians, 90th percentiles."""
    end = {m: 1e3 * column(rows, m, "end_m") for m in METHODS}
    turn = {m: column(rows, m, "end_rad") for m in ("pbpf", "dope")}
    around = [
        " / ".join(
            f"{1e3 * np.median(column(rows, method, when)):.0f}"
            for method in ("pbpf", "dope")
        )
        for when in ("before_slip_m", "after_slip_m")
    ]
    share = np.mean(end["pbpf"] <= 0.35 * end["dope"])
    cells = [
        run,
        blackout,
        f"{1e3 * np.median(column(rows, 'pbpf', 'moved_m')):.0f}",
        *(spread(end[m], 0) for m in METHODS),
        f"{np.median(end['pbpf'] / end['dope']):.2f}",
        f"{100 * share:.0f} %",
        *(spread(x, 2) for x in turn.values()),
        *around,
    ]
    return "| " + " | ".join(cells) + " |"


def run(args: argparse.Namespace) -> None:
    """Evaluates all bags in a folder; prints a table, writes all rows."""
    files = sorted(args.data.glob("*.bag"))
    if not files:
        raise ValueError(f"there are no bags in {args.data}")
    jobs = itertools.product(files, _BLACKOUTS, range(args.seeds), METHODS)
    rows = EvaluateAll(evaluate, jobs, num_processes=args.jobs)
    print("At the end of the blackout: median / 90th percentile over seeds.")
    print("Before and after the slip: means, of PBPF / hold")
    print(_HEADER)
    for path, which in itertools.product(files, _BLACKOUTS):
        chosen = [
            row
            for row in rows
            if (row["run"], row["blackout"]) == (path.stem, which)
        ]
        print(summarize(path.stem, which, chosen))
    WriteRows(args.out, rows)


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    return RunEvaluation(
        argv,
        run,
        name="evaluate_push_bags",
        description=__doc__,
        data="bags",
        seeds=10,
        out="push_bags.csv",
    )


if __name__ == "__main__":
    sys.exit(main())
