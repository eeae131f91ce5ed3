"""Compares the simulated detector with traces of the authors' real one.

A trace holds the errors of the last detection at every update. The same is
computed for simulated runs, with many detectors for each. The real number
should be among the simulated ones. There is one trace per scene at most; beside
it are the means of the paper's tables. It is also counted how much of the
objects the images show. See detector/real_traces.py for the files of traces.
"""

import argparse
import csv
from functools import partial
import os
from pathlib import Path
import sys

from tqdm import tqdm

from pbpf_drake.diagrams.detector.detector_table import (
    COLUMNS,
    format_statistics,
    make_statistic_rows,
)
from pbpf_drake.diagrams.detector.real_traces import ReadTrace
from pbpf_drake.diagrams.detector.simulated_errors import DescribeRun
from pbpf_drake.diagrams.jobs.executors import LocalExecutor
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.diagrams.paper.paper_values import (
    SCENES,
    paper_runs_and_repeats,
)


def _parse(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0],
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("traces", type=Path, help="folder of the real traces")
    add("--scenes", nargs="+", choices=SCENES, default=list(SCENES),
        help="what to simulate")  # fmt: skip
    add("--runs", type=int, default=None,
        help="runs to record of each scene; the paper's if none")  # fmt: skip
    add("--draws", type=int, default=50, help="detectors to draw per run")
    add("--jobs", type=int, default=os.cpu_count(),
        help="recordings at a time")  # fmt: skip
    add("--out", type=Path, default=Path("detector.csv"),
        help="CSV file to write")  # fmt: skip
    return parser.parse_args(argv)


def _check(args: argparse.Namespace) -> None:
    """Raises ValueError or OSError if an argument can't be used."""
    for name in "runs", "draws", "jobs":
        value = getattr(args, name)
        if value is not None and value < 1:
            raise ValueError(f"--{name} is {value}; expected at least 1")
    if not args.traces.is_dir():
        raise FileNotFoundError(f"There is no folder {args.traces}")
    if all(ReadTrace(args.traces, scene) is None for scene in SCENES):
        raise FileNotFoundError(
            f"There is no trace in {args.traces}; expected files as "
            "cracker_scene1_early_DOPE_pos_01.csv"
        )
    args.out.parent.mkdir(parents=True, exist_ok=True)


def _simulate(
    args: argparse.Namespace,
) -> dict[tuple[str, str], list[dict[str, float]]]:
    """Returns the statistics of all runs and draws, by scene and object."""
    tasks = [
        (scene, run)
        for scene in args.scenes
        for run in range(args.runs or paper_runs_and_repeats(scene)[0])
    ]
    found: dict[tuple[str, str], list[dict[str, float]]] = {}
    with LocalExecutor(args.jobs) as executor:
        results = executor.map(partial(DescribeRun, draws=args.draws), tasks)
        for (scene, _), runs in zip(
            tasks, tqdm(results, total=len(tasks), desc="record"), strict=True
        ):
            for object_name, statistics in runs:
                found.setdefault((scene, object_name), []).append(statistics)
    return found


def run(args: argparse.Namespace) -> None:
    """Records, draws and compares; see _parse for the arguments."""
    _check(args)
    rows = []
    for (scene, object_name), simulated in _simulate(args).items():
        trace = ReadTrace(args.traces, scene)
        rows += make_statistic_rows(scene, object_name, simulated, trace)
    print(format_statistics(rows))
    with open(args.out, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)
    print(f"\nWritten to {args.out.resolve()}")


def main(argv: list[str] | None = None) -> int:
    """Runs the script; returns its exit code."""
    args = _parse(argv)
    return RunCommand("compare_detector", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
