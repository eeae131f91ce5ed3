"""What the evaluations of recorded pushes have in common."""

import argparse
from collections.abc import Callable, Iterable
import csv
from dataclasses import replace
import os
from pathlib import Path
import tempfile
from typing import Any

import numpy as np
from tqdm import tqdm

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.diagrams.jobs.executors import LocalExecutor
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.log.mcap_log_writer import WriteLog
from pbpf_drake.tracking.tracking_diagram import DefaultConfig

# The methods that are compared on pushes, in the order of the tables' columns.
COMPARED_METHODS = ("pbpf", "cvpf", "dope")
# What tells the rows of one method apart.
_IDENTITY = ("run", "blackout", "dropout", "seed")

Row = dict[str, float | str]


def ConfigForPushes(scene: Scene, method: str, seed: int) -> ParticleFilterConfig:
    """Returns the config of a method for recorded pushes.

    PBPF recovers lost tracks in them: people poke the block, and these
    detections have no bias that would look like a lost track.

    Args:
        scene: with the filter's own config.
        method: one of COMPARED_METHODS.
        seed: of the filter.
    """
    config = replace(DefaultConfig(scene, method), seed=seed)
    return replace(config, recover_lost_tracks=method == "pbpf")


def ThroughMcap(log: Log, scene: Scene) -> Log:
    """Takes the log through a file, as any log of a user comes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "push.mcap"
        WriteLog(filename=path, scene_topics=scene.topics, log=log)
        return ReadLog(filename=path, scene=scene, joint_names=log.joints.names)


def EvaluateAll(
    evaluate: Callable[[Any], Row], jobs: Iterable[Any], *, num_processes: int
) -> list[Row]:
    """Returns a row of results for every job, with a progress bar.

    Args:
        evaluate: a function of a module; called in another process.
        jobs: its arguments.
        num_processes: how many run at the same time.
    """
    jobs = list(jobs)
    with LocalExecutor(num_processes) as executor:
        return list(
            tqdm(executor.map(evaluate, jobs), total=len(jobs), unit="track")
        )


def WriteRows(filename: Path, rows: list[Row]) -> None:
    """Writes rows of results as a CSV file, and says where."""
    with open(filename, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=rows[0])
        writer.writeheader()
        writer.writerows(rows)
    print(f"Written to {filename}")


def column(rows: list[Row], method: str, name: str) -> np.ndarray:
    """Returns one column of a method's rows, in the same order for all methods.

    Args:
        rows: of all methods.
        method: whose to return.
        name: the column's.
    """
    chosen = [row for row in rows if row["method"] == method]
    chosen.sort(key=lambda row: [row[k] for k in _IDENTITY if k in row])
    return np.array([row[name] for row in chosen], dtype=float)


def spread(values: np.ndarray, digits: int) -> str:
    """Returns a cell of a table: the median and the 90th percentile."""
    high = np.percentile(values, 90)
    return f"{np.median(values):.{digits}f} / {high:.{digits}f}"


def RunEvaluation(
    argv: list[str] | None,
    run: Callable[[argparse.Namespace], None],
    *,
    name: str,
    description: str,
    data: str,
    seeds: int,
    out: str,
) -> int:
    """Runs the command of an evaluation; returns its exit code.

    Args:
        argv: the command line; None is the process's own.
        run: the evaluation.
        name: of the command.
        description: what it does; its first line is shown.
        data: what the folder holds.
        seeds: how many by default.
        out: the file of results by default.
    """
    parser = argparse.ArgumentParser(description=description.split("\n")[0])
    parser.add_argument("data", type=Path, help=f"folder of {data}")
    parser.add_argument("--seeds", type=int, default=seeds)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--out", type=Path, default=Path(out))
    args = parser.parse_args(argv)
    return RunCommand(name, lambda: run(args))
