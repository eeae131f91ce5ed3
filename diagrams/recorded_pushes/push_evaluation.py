"""What the evaluations of recorded pushes have in common: how they are run."""

import argparse
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
import os
from pathlib import Path
import tempfile
from typing import Generic, TypeVar

from tqdm import tqdm

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.diagrams.jobs.executors import LocalExecutor
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.diagrams.recorded_pushes.push_rows import Row, WriteRows
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.log.mcap_log_writer import WriteLog
from pbpf_drake.tracking.tracking_diagram import DefaultConfig

# The methods that are compared, in the order of the tables' columns.
COMPARED_METHODS = ("pbpf", "cvpf", "dope")

Job = TypeVar("Job")


@dataclass(frozen=True, kw_only=True)
class PushEvaluation(Generic[Job]):
    """One command that evaluates methods on a folder of recordings.

    Attributes:
        name: of the command.
        description: what it does; its first line is shown.
        recordings: what the folder has to hold, in words.
        pattern: of their paths within the folder.
        seeds: how many by default.
        out: the file of results by default.
        make_jobs: returns what to compute of some recordings with so many
            seeds.
        evaluate: computes one row; a function of a module, as it is called in
            another process.
        make_table: yields the lines that sum all rows up.
    """

    name: str
    description: str
    recordings: str
    pattern: str
    seeds: int
    out: str
    make_jobs: Callable[[Sequence[Path], int], Iterable[Job]]
    evaluate: Callable[[Job], Row]
    make_table: Callable[[Sequence[Row]], Iterator[str]]


def RunEvaluation(
    evaluation: PushEvaluation[Job], argv: list[str] | None
) -> int:
    """Runs the command of an evaluation; returns its exit code.

    Args:
        evaluation: what to do.
        argv: the command line; None is the process's own.
    """
    parser = argparse.ArgumentParser(
        description=evaluation.description.split("\n")[0]
    )
    add = parser.add_argument
    add("data", type=Path, help=f"folder of {evaluation.recordings}")
    add("--seeds", type=int, default=evaluation.seeds)
    add("--jobs", type=int, default=os.cpu_count())
    add("--out", type=Path, default=Path(evaluation.out))
    args = parser.parse_args(argv)
    return RunCommand(evaluation.name, lambda: _run(evaluation, args))


def _run(evaluation: PushEvaluation[Job], args: argparse.Namespace) -> None:
    """Evaluates all recordings; prints a table, and writes all rows."""
    files = sorted(args.data.glob(evaluation.pattern))
    if not files:
        raise ValueError(f"there are no {evaluation.recordings} in {args.data}")
    jobs = list(evaluation.make_jobs(files, args.seeds))
    if not jobs:
        raise ValueError(f"there is nothing to evaluate in {args.data}")
    with LocalExecutor(args.jobs) as executor:
        found = executor.map(evaluation.evaluate, jobs)
        rows = list(tqdm(found, total=len(jobs), unit="track"))
    for line in evaluation.make_table(rows):
        print(line)
    WriteRows(args.out, rows)


def ConfigForPushes(
    scene: Scene, method: str, seed: int
) -> ParticleFilterConfig:
    """Returns the config of a method for recorded pushes.

    PBPF recovers lost tracks in them: people poke the block, and these
    detections have no bias that would look like a lost track.

    Args:
        scene: has the config that all methods share.
        method: one of COMPARED_METHODS.
        seed: of the filter.
    """
    config = replace(DefaultConfig(scene, method), seed=seed)
    return replace(config, recover_lost_tracks=method == "pbpf")


def ThroughMcap(log: Log, scene: Scene) -> Log:
    """Writes a log and reads it again: a user's own comes from a file, too."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "push.mcap"
        WriteLog(filename=path, scene_topics=scene.topics, log=log)
        return ReadLog(filename=path, scene=scene, joint_names=log.joints.names)
