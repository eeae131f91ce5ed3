"""Evaluates PBPF on the dropouts of a real camera while a block is pushed.

Robot, detections and dropouts are those that were recorded; nothing is
simulated. At the first detection after every dropout, each method says where
the block is before it knows that detection, and is compared with it. So there
is one run for every dropout, on the log up to then. The filters run twice: with
the noise of the paper's preset, which fits DOPE, and with the scene's, which
fits this camera.

The recordings are those of robinzhoucmu/PlanarManipulationToolBox, one CSV file
each; see two_finger_log.py for their columns.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
import itertools
from pathlib import Path
import sys

import numpy as np

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.jobs.scene_run import scene_path
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
)
from pbpf_drake.diagrams.recorded_pushes.two_finger_log import (
    ReadTwoFingerPush,
    cut_to_update,
    find_dropouts,
    was_lifted,
)
from pbpf_drake.diagrams.tables.text_tables import (
    format_quantiles,
    markdown_line,
)
from pbpf_drake.log.log_records import Log
from pbpf_drake.log.pose_interpolation import interpolate_poses
from pbpf_drake.results.pose_errors import position_error, rotation_error
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.tracking.tracking_diagram import Track

# A dropout is longer than this, just above the period, so that at least one
# update has no detection (in seconds).
_SHORTEST = 0.161
# The kinds of dropouts, and what the table calls them.
_KINDS = {
    "long": "pushed, 0.4 s or longer",
    "short": "pushed, shorter",
    "pause": "pause between pushes",
}
# From here on a dropout is long (in seconds).
_LONG = 0.4
_NOISES = ("paper", "camera")

# A recording, which of its dropouts, whose noise, a seed, and a method.
Job = tuple[Path, int, str, int, str]


@cache
def _scene() -> Scene:
    return LoadScene(scene_path("two_finger_push"))


@cache
def _read(filename: Path) -> Log:
    scene = _scene()
    height = MakePredictionModel(scene).nominal_poses[0, 6]
    return ReadTwoFingerPush(
        filename, X_WC=scene.camera.pose(), height=height, object_name="block"
    )


def _dropouts(log: Log) -> np.ndarray:
    return find_dropouts(log.ground_truth["block"].times, _SHORTEST)


def choose_config(
    scene: Scene, noise: str, method: str, seed: int
) -> ParticleFilterConfig:
    """Returns a method's config, with the noise of "paper" or of "camera"."""
    config = ConfigForPushes(scene, method, seed)
    if noise == "camera":
        return config
    paper = ParticleFilterConfig()
    return replace(
        config,
        process_noise=paper.process_noise,
        detection_noise=paper.detection_noise,
    )


def evaluate(job: Job) -> Row:
    """Tracks one run up to the end of one dropout; returns a row of results.

    ``moved_m`` and ``moved_rad`` say how far the block moved in the dropout,
    ``error_m`` and ``error_rad`` how far the estimate is from the detection
    that ends it (in meters and radians).
    """
    filename, index, noise, seed, method = job
    scene, whole = _scene(), _read(filename)
    start, end = dropout = _dropouts(whole)[index]
    config = choose_config(scene, noise, method, seed)
    log = ThroughMcap(cut_to_update(whole, end, config.period), scene)
    record = Track(scene=scene, log=log, method=method, config=config)
    q, p = interpolate_poses(whole.ground_truth["block"], dropout)
    estimate = record.poses[-1, 0]
    lifted = was_lifted(whole.joints, start, end)
    kind = "long" if end - start >= _LONG else "short"
    return {
        "run": filename.stem,
        "dropout": index,
        "kind": "pause" if lifted else kind,
        "noise": noise,
        "seed": seed,
        "method": method,
        "start_s": float(start),
        "length_s": float(end - start),
        "moved_m": float(position_error(*p)),
        "moved_rad": float(rotation_error(*q)),
        "error_m": float(position_error(estimate[4:], p[1])),
        "error_rad": float(rotation_error(estimate[:4], q[1])),
    }


_HEADER = """\
| dropouts | noise | number | length [s] | moved [mm] | moved [rad] \
| PBPF [mm] | CVPF [mm] | hold [mm] | PBPF [rad] | CVPF [rad] | hold [rad] |
|---|---|---|---|---|---|---|---|---|---|---|---|"""


def summarize(title: str, noise: str, rows: Sequence[Row]) -> str:
    """Returns a line of a Markdown table: medians, 90th percentiles."""
    number = len({(row["run"], row["dropout"]) for row in rows})
    shift = {m: 1e3 * column(rows, m, "error_m") for m in COMPARED_METHODS}
    turn = {m: column(rows, m, "error_rad") for m in COMPARED_METHODS}
    cells = [
        title,
        noise,
        f"{number}",
        f"{np.median(column(rows, 'dope', 'length_s')):.2f}",
        f"{1e3 * np.median(column(rows, 'dope', 'moved_m')):.1f}",
        f"{np.median(column(rows, 'dope', 'moved_rad')):.2f}",
        *(format_quantiles(x, 1) for x in shift.values()),
        *(format_quantiles(x, 2) for x in turn.values()),
    ]
    return markdown_line(cells)


def make_jobs(files: Sequence[Path], num_seeds: int) -> Iterator[Job]:
    """Yields what to evaluate: each dropout, noise, seed and method."""
    dropouts = [(f, i) for f in files for i in range(len(_dropouts(_read(f))))]
    for (file, index), noise, seed, method in itertools.product(
        dropouts, _NOISES, range(num_seeds), COMPARED_METHODS
    ):
        yield file, index, noise, seed, method


def make_table(rows: Sequence[Row]) -> Iterator[str]:
    """Yields the lines of a table: one for each kind of dropout and noise."""
    yield "At the first detection after a dropout: median / 90th percentile"
    yield _HEADER
    for kind, noise in itertools.product(_KINDS, _NOISES):
        if chosen := choose(rows, kind=kind, noise=noise):
            yield summarize(_KINDS[kind], noise, chosen)


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    evaluation = PushEvaluation(
        name="evaluate_dropouts",
        make_jobs=make_jobs,
        evaluate=evaluate,
        make_table=make_table,
        description=__doc__,
        recordings="CSV files",
        pattern="**/*.csv",
        seeds=3,
        out="dropouts.csv",
    )
    return RunEvaluation(evaluation, argv)


if __name__ == "__main__":
    sys.exit(main())
