"""Tracks one log with several methods and seeds, and compares their errors.

Each run has one thread; several run at a time. The single-snapshot estimator
"dope" draws nothing at random, so that it is run once.
"""

import argparse
from collections.abc import Mapping, Sequence
from concurrent.futures import as_completed
import csv
from dataclasses import replace
import itertools
import os
from pathlib import Path
import sys
from typing import Any

import numpy as np
from tqdm import tqdm

from pbpf_drake.config.particle_filter_config import METHODS
from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.jobs.executors import LocalExecutor
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.results.report import MakeReport
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.tracking_diagram import DefaultConfig, Track

_ERRORS = ("position_error_m", "rotation_error_rad")
_COLUMNS = ("object", "method", "seed", *_ERRORS)
# What _COLUMNS has.
_Row = tuple[str, str, int, float | None, float | None]
_MEANS = ("position [m]", "sd", "/ dope", "rotation [rad]", "sd", "/ dope")


def _parse(argv: list[str] | None) -> argparse.Namespace:
    log = data_folder("diagrams") / "logs" / "cheezit_1.mcap"
    scene = data_folder("diagrams") / "scenes" / "cheezit_1.yaml"
    parser = argparse.ArgumentParser(
        description="Tracks a log with several methods and seeds, and "
        "writes each run's mean errors to compare.csv.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--log", type=Path, default=log, help="MCAP file with ground truth")
    add("--scene", type=Path, default=scene, help="YAML file of the scene")
    add("--methods", nargs="+", choices=METHODS, default=METHODS, help="which")
    add("--seeds", type=int, default=10, help="runs per method, from seed 0")
    add("--jobs", type=int, default=os.cpu_count(), help="processes")
    add("--out", type=Path, default=Path("pbpf_compare"), help="folder")
    return parser.parse_args(argv)


def _track(
    log_file: Path, scene_file: Path, method: str, seed: int
) -> dict[str, Any]:
    """Returns the report of one run; this is what a process does."""
    scene = LoadScene(scene_file)
    model = MakePredictionModel(scene)
    log = ReadLog(
        filename=log_file,
        scene=scene,
        joint_names=model.joint_names,
        facts=model.facts,
    )
    config = replace(DefaultConfig(scene, method), seed=seed, parallelism=1)
    record = Track(scene=scene, log=log, method=method, config=config)
    return MakeReport([record], log.ground_truth)["runs"][0]


def _track_all(args: argparse.Namespace) -> list[dict[str, Any]]:
    """Returns the reports of all runs, method by method."""
    tasks = [
        (args.log, args.scene, method, seed)
        for method in dict.fromkeys(args.methods)
        for seed in range(1 if method == "dope" else args.seeds)
    ]
    with LocalExecutor(args.jobs) as pool:
        futures = [pool.submit(_track, *task) for task in tasks]
        list(tqdm(as_completed(futures), total=len(tasks), unit="run"))
        return [future.result() for future in futures]


def _rows(runs: Sequence[Mapping[str, Any]]) -> list[_Row]:
    """Returns _COLUMNS of each run and object; None is unknown."""
    rows: list[_Row] = []
    for run in runs:
        for name, errors in run["objects"].items():
            position, rotation = (errors[e]["mean"] for e in _ERRORS)
            rows.append((name, run["method"], run["seed"], position, rotation))
    return rows


def _table(rows: Sequence[_Row]) -> str:
    """Returns a line per object and method; - where a number is unknown."""
    names = dict.fromkeys(row[0] for row in rows)
    methods = dict.fromkeys(row[1] for row in rows)
    lines: list[tuple[str, ...]] = [("object", "method", "runs", *_MEANS)]
    for name, method in itertools.product(names, methods):
        means, dope = (
            np.array([row[3:] for row in rows if row[:2] == (name, m)], float)
            for m in (method, "dope")
        )
        ratio = means.mean(0) / (dope[0] if len(dope) else np.nan)
        values = np.stack([means.mean(0), means.std(0), ratio], axis=1).ravel()
        cells = [f"{x:.4f}" if np.isfinite(x) else "-" for x in values]
        lines.append((name, method, str(len(means)), *cells))
    return "\n".join("".join(c.rjust(16) for c in line) for line in lines)


def run(args: argparse.Namespace) -> None:
    """Compares; prints a table, and writes all rows."""
    args.out.mkdir(parents=True, exist_ok=True)
    rows = _rows(_track_all(args))
    with (args.out / "compare.csv").open("w", newline="") as file:
        csv.writer(file).writerows([_COLUMNS, *rows])
    print(_table(rows))


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    args = _parse(argv)
    return RunCommand("compare_methods", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
