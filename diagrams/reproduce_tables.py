"""Reproduces the paper's evaluation: its two tables and its figures.

Every run of every scene is simulated and recorded, and every method is
evaluated on it, by default as often as in the paper. Each result is stored as
soon as it is there: killed and started again, the command goes on where it
was. See --help.
"""

import argparse
from collections.abc import Sequence
from functools import partial
import os
from pathlib import Path
import sys

from pbpf_drake.config.particle_filter_config import METHODS
from pbpf_drake.diagrams.jobs.executors import ClusterExecutor, LocalExecutor
from pbpf_drake.diagrams.jobs.job_queue import ExecutorFactory, Failure
from pbpf_drake.diagrams.jobs.result_store import write_atomically
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.diagrams.paper.error_bands import PlotBands
from pbpf_drake.diagrams.paper.evaluation import Result
from pbpf_drake.diagrams.paper.paper_comparisons import (
    compare_all,
    comparisons_csv,
    format_comparisons,
)
from pbpf_drake.diagrams.paper.paper_rows import make_paper_rows
from pbpf_drake.diagrams.paper.paper_tables import (
    format_metrics,
    format_tables,
    metrics_csv,
    paper_csv,
)
from pbpf_drake.diagrams.paper.paper_values import SCENES
from pbpf_drake.diagrams.paper.protocol import Protocol
from pbpf_drake.diagrams.paper.protocol_runner import RunProtocol

# Jobs that a cluster is given at a time, however many workers it has.
_CLUSTER_AHEAD = 256


def _parse(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="reproduce_tables",
        description="Records runs of the paper's scenes, evaluates all "
        "methods on them, and writes the paper's tables and figures.",
    )
    add = parser.add_argument
    add("--scenes", nargs="+", default=list(SCENES),
        help="names of scenes, or YAML files (default: the paper's "
        "eight)")  # fmt: skip
    add("--methods", nargs="+", choices=METHODS,
        help="for all scenes (default: those that the paper has for "
        "each)")  # fmt: skip
    add("--runs", type=int,
        help="of each scene (default: 10, 1 for scene_5)")  # fmt: skip
    add("--repeats", type=int,
        help="of each method on each run (default: 10, 20 for "
        "scene_5)")  # fmt: skip
    add("--duration", type=float,
        help="of each log, in seconds (default: the scene's)")  # fmt: skip
    add("--particles", type=int,
        help="of each filter (default: the scene's, 150 for "
        "cvpf)")  # fmt: skip
    add("--jobs", type=int, default=os.cpu_count(),
        help="processes on this machine (default: %(default)s)")  # fmt: skip
    add("--scheduler", metavar="ADDRESS",
        help="of a Dask scheduler whose workers run the jobs "
        "instead")  # fmt: skip
    add("--out", type=Path, default=Path("pbpf_tables"),
        help="folder for logs, results, tables and figures (default: "
        "%(default)s)")  # fmt: skip
    return parser.parse_args(argv)


def write_outputs(results: Sequence[Result], folder: Path, note: str) -> str:
    """Writes tables and figures; returns the tables as text.

    Args:
        results: at least one.
        folder: to write to.
        note: above the tables, or empty.
    """
    rows, comparisons = make_paper_rows(results), compare_all(results)
    texts = {}
    for ending, markdown in ("txt", False), ("md", True):
        parts = [
            note,
            format_tables(rows, markdown=markdown),
            "Other errors",
            format_metrics(rows, markdown=markdown),
            "Mean errors of two methods, with 95 % confidence intervals",
            format_comparisons(comparisons, markdown=markdown),
        ]
        texts[f"tables.{ending}"] = "\n\n".join(filter(None, parts)) + "\n"
    texts["paper_tables.csv"] = paper_csv(rows)
    texts["metrics.csv"] = metrics_csv(rows)
    texts["comparisons.csv"] = comparisons_csv(comparisons)
    for name, text in texts.items():
        write_atomically(folder / name, text.encode())
    for scene in dict.fromkeys(row.scene for row in rows):
        PlotBands(
            [r for r in results if r.scene == scene],
            folder / f"errors_{scene}.png",
        )
    return texts["tables.txt"]


def _note(protocol: Protocol, failures: Sequence[Failure]) -> str:
    """Returns in what our numbers are not of the paper's protocol."""
    said = []
    if protocol.duration is not None:
        said.append(f"logs of {protocol.duration:g} s")
    if protocol.particles is not None:
        said.append(f"{protocol.particles} particles")
    if failures:
        names = ", ".join(failure.name for failure in failures)
        said.append(f"without what failed ({names})")
    return f"Not the paper's protocol: {', '.join(said)}." if said else ""


def run(args: argparse.Namespace) -> None:
    """Evaluates and writes everything; see _parse for the arguments.

    Raises:
        ValueError, OSError: an argument can't be used, or some of the work
            has failed; the message says what and why.
    """
    protocol = Protocol(
        scenes=args.scenes,
        methods=args.methods,
        runs=args.runs,
        repeats=args.repeats,
        duration=args.duration,
        particles=args.particles,
    )
    if args.jobs < 1:
        raise ValueError(f"--jobs is {args.jobs}; expected at least 1")
    # Not after the first hour.
    args.out.mkdir(parents=True, exist_ok=True)
    make_executor: ExecutorFactory = partial(LocalExecutor, args.jobs)
    ahead = 2 * args.jobs
    if args.scheduler:
        make_executor = partial(ClusterExecutor, args.scheduler)
        ahead = _CLUSTER_AHEAD
    results, failures = RunProtocol(
        protocol, args.out, make_executor, ahead=ahead
    )
    if results:
        print(write_outputs(results, args.out, _note(protocol, failures)))
        print(f"Written to {args.out.resolve()}")
    if failures:
        lines = [f"{failure.name}: {failure.reason}" for failure in failures]
        raise ValueError(
            f"{len(failures)} failed, the others are stored\n"
            + "\n".join(lines)
        )


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    args = _parse(argv)
    return RunCommand("reproduce_tables", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
