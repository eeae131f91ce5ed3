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

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
import itertools
from pathlib import Path
import sys

import numpy as np

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.jobs.scene_run import scene_path
from pbpf_drake.diagrams.recorded_pushes.planar_push_log import (
    SimulateDetections,
)
from pbpf_drake.diagrams.recorded_pushes.push_evaluation import (
    COMPARED_METHODS,
    ConfigForPushes,
    PushEvaluation,
    RunEvaluation,
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
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.log.pose_interpolation import interpolate_poses
from pbpf_drake.poses.quaternions import conjugate, rotate
from pbpf_drake.results.pose_errors import compute_errors
from pbpf_drake.tracking.tracking_diagram import Track

_BLACKOUTS = ("contact", "earlier", "slip")
# Of a blackout (in seconds).
_LENGTH = 0.5
_JOINTS = ("pusher_x", "pusher_y")
# Half the length of the block's sides (in meters).
_HALF_SIDE = 0.049475
# How far the probe's axis is from a side in contact: the probe's radius, and
# the error of calibration and of the motion capture's delay (in meters).
_TOUCH = 0.004745 + 0.002

# A bag, the name of a blackout, a seed, and a method.
Job = tuple[Path, str, int, str]


@cache
def _scene() -> Scene:
    return LoadScene(scene_path("planar_push_bag"))


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


def evaluate(job: Job) -> Row:
    """Tracks one run; returns a row of results.

    Errors are in meters and radians: at the blackout's end, and their means
    while the block is pushed and after it slipped off.
    """
    filename, which, seed, method = job
    scene = _scene()
    (name,) = scene.object_names()
    log = ReadLog(filename=filename, scene=scene, joint_names=_JOINTS)
    truth = log.ground_truth[name]
    config = ConfigForPushes(scene, method, seed)
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


def summarize(run: str, blackout: str, rows: Sequence[Row]) -> str:
    """Returns a line of a Markdown table: medians, 90th percentiles."""
    end = {m: 1e3 * column(rows, m, "end_m") for m in COMPARED_METHODS}
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
        *(format_quantiles(end[m], 0) for m in COMPARED_METHODS),
        f"{np.median(end['pbpf'] / end['dope']):.2f}",
        f"{100 * share:.0f} %",
        *(format_quantiles(x, 2) for x in turn.values()),
        *around,
    ]
    return markdown_line(cells)


def make_jobs(files: Sequence[Path], num_seeds: int) -> Iterator[Job]:
    """Yields what to evaluate: each bag, blackout, seed and method."""
    yield from itertools.product(
        files, _BLACKOUTS, range(num_seeds), COMPARED_METHODS
    )


def make_table(rows: Sequence[Row]) -> Iterator[str]:
    """Yields the lines of a table: one for each run and blackout."""
    yield "At the end of the blackout: median / 90th percentile over seeds."
    yield "Before and after the slip: means, of PBPF / hold"
    yield _HEADER
    for run, blackout in itertools.product(distinct(rows, "run"), _BLACKOUTS):
        chosen = choose(rows, run=run, blackout=blackout)
        yield summarize(run, blackout, chosen)


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    evaluation = PushEvaluation(
        name="evaluate_push_bags",
        make_jobs=make_jobs,
        evaluate=evaluate,
        make_table=make_table,
        description=__doc__,
        recordings="bags",
        pattern="*.bag",
        seeds=10,
        out="push_bags.csv",
    )
    return RunEvaluation(evaluation, argv)


if __name__ == "__main__":
    sys.exit(main())
