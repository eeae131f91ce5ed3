"""Tracks one log with several methods and seeds, and compares their errors.

Every run is a process of its own task with one thread. The single-snapshot
estimator "dope" draws nothing at random, so that it is run once.
"""

import argparse
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
import csv
from dataclasses import replace
import multiprocessing
import os
from pathlib import Path
import sys
from typing import Any

import numpy as np
from tqdm import tqdm

from pbpf_drake.mcap_log_reader import ReadLog
from pbpf_drake.particle_filter_config import METHODS
from pbpf_drake.prediction_model import MakePredictionModel
from pbpf_drake.report import MakeReport
from pbpf_drake.scene import LoadScene
from pbpf_drake.scene_models import data_folder
from pbpf_drake.tracking import DefaultConfig, Track

_ERRORS = ("position_error_m", "rotation_error_rad")
_TITLES = ("object", "method", "seeds", "position [m]", "spread", "/ dope",
           "rotation [rad]", "spread", "/ dope")  # fmt: skip


def _parse(argv: list[str] | None) -> argparse.Namespace:
    folder = data_folder("diagrams")
    parser = argparse.ArgumentParser(
        description="Tracks a log with several methods and seeds; prints the "
        "mean errors and writes those of each run to compare.csv.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--log", type=Path, default=folder / "logs" / "cheezit_1.mcap",
        help="MCAP file of ROS 2 messages, with ground truth")  # fmt: skip
    add("--scene", type=Path, default=folder / "scenes" / "cheezit_1.yaml",
        help="YAML file of the scene")  # fmt: skip
    add("--methods", nargs="+", choices=METHODS, default=list(METHODS),
        help="what to compare")  # fmt: skip
    add("--seeds", type=int, default=10,
        help="number of runs per method, from seed 0 on")  # fmt: skip
    add("--jobs", type=int, default=os.cpu_count(),
        help="number of processes")  # fmt: skip
    add("--out", type=Path, default=Path("pbpf_compare"),
        help="folder to write to")  # fmt: skip
    return parser.parse_args(argv)


def _track(log: Path, scene: Path, method: str, seed: int) -> dict[str, Any]:
    """Returns the report of one run; this is what a process does."""
    scene = LoadScene(scene)
    joint_names = MakePredictionModel(scene).joint_names
    log = ReadLog(filename=log, scene=scene, joint_names=joint_names)
    config = replace(DefaultConfig(scene, method), seed=seed, num_threads=1)
    record = Track(scene=scene, log=log, method=method, config=config)
    return MakeReport([record], log.ground_truth)["runs"][0]


def _track_all(args: argparse.Namespace) -> list[dict[str, Any]]:
    """Returns the reports of all runs, sorted by method and seed."""
    tasks = [
        (args.log, args.scene, method, seed)
        for method in dict.fromkeys(args.methods)
        for seed in range(1 if method == "dope" else args.seeds)
    ]
    # Numpy's own threads would compete with the other processes.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(args.jobs, mp_context=spawn) as pool:
        futures = [pool.submit(_track, *task) for task in tasks]
        try:
            for future in tqdm(as_completed(futures), total=len(futures)):
                future.result()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
        return [future.result() for future in futures]


def _means(runs: Sequence[Mapping], name: str, method: str) -> np.ndarray:
    """Returns the mean errors (runs, 2) in position and rotation."""
    objects = [run["objects"][name] for run in runs if run["method"] == method]
    means = [[o[error]["mean"] for error in _ERRORS] for o in objects]
    return np.array(means, dtype=float).reshape(-1, 2)


def _table(runs: Sequence[Mapping]) -> str:
    """Returns a line per object and method; - where a number is unknown."""
    rows = [_TITLES]
    for name in runs[0]["objects"]:
        dope = _means(runs, name, "dope")
        for method in dict.fromkeys(run["method"] for run in runs):
            means = _means(runs, name, method)
            ratios = means.mean(0) / (dope[0] if len(dope) else np.nan)
            cells = np.stack([means.mean(0), means.std(0), ratios], axis=1)
            cells = [f"{x:.4f}" if x == x else "-" for x in cells.ravel()]
            rows.append((name, method, str(len(means)), *cells))
    widths = [max(map(len, cells)) for cells in zip(*rows, strict=True)]
    lines = [zip(row, widths, strict=True) for row in rows]
    return "\n".join("  ".join(c.rjust(w) for c, w in line) for line in lines)
