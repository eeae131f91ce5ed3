"""Pushes an object to a goal behind an obstacle, by an estimate of its pose.

A manipulation diagram with the filter in its loop: an arm and its controllers,
a camera that can't see behind the obstacle, a detector, an estimator, and what
decides where to push by what the estimator says. The same is done with the
last detection in place of the filter's estimate, and with the truth. See
closed_loop/closed_loop_diagram.py for how they are connected, and
closed_loop/push_run.py for what counts as a success.
"""

import argparse
import itertools
from pathlib import Path
import sys

from tqdm import tqdm

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.closed_loop.closed_loop_diagram import FEEDBACKS
from pbpf_drake.diagrams.closed_loop.closed_loop_table import (
    WriteOutcomes,
    format_outcomes,
)
from pbpf_drake.diagrams.closed_loop.push_run import RunTask
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.scene.scene_models import data_folder


def _parse(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Pushes an object to goals behind an obstacle, by "
        "different estimates of its pose.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--feedback", nargs="+", choices=FEEDBACKS,
        default=["pbpf-v", "dope", "truth"],
        help="what the controller goes by")  # fmt: skip
    add("--goals", type=int, default=20, help="number of random goals")
    add("--first", type=int, default=0, help="seed of the first one")
    add("--out", type=Path, default=Path("closed_loop_push.csv"),
        help="CSV file to write")  # fmt: skip
    return parser.parse_args(argv)


def run(args: argparse.Namespace) -> None:
    """Runs all tasks; see _parse for the arguments."""
    scenes = data_folder("diagrams") / "scenes"
    scene = LoadScene(scenes / "closed_loop_push.yaml")
    seeds = range(args.first, args.first + args.goals)
    outcomes = []
    tasks = list(itertools.product(seeds, args.feedback))
    for seed, feedback in tqdm(tasks, desc="push", unit="run"):
        outcomes.append(RunTask(scene, feedback, seed))
        # After each run, so that nothing is lost if the command is stopped.
        WriteOutcomes(outcomes, args.out)
    print(format_outcomes(outcomes))
    print(f"Written to {args.out.resolve()}")


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    args = _parse(argv)
    return RunCommand("closed_loop_push", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
