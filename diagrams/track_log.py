"""Tracks the objects of a recorded manipulation: the main job.

Without arguments it tracks the log that comes with pbpf_drake: a cracker box
that is pushed behind an obstacle. See --help for everything else.
"""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
import os
from pathlib import Path
import sys

from pydrake.geometry import Meshcat
from tqdm import tqdm

from pbpf_drake.config.particle_filter_config import (
    METHODS,
    ParticleFilterConfig,
)
from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.log.log_inspection import InspectLog
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.results.input_usage import FormatUsage, UsageRow
from pbpf_drake.results.report_table import FormatTable
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.track_outputs import (
    TrackedLog,
    WriteOutputs,
    WrittenOutputs,
)
from pbpf_drake.tracking.track_usage import usage_rows, usage_warnings
from pbpf_drake.tracking.tracking_diagram import (
    DefaultConfig,
    NumSteps,
    Track,
    TrackInterrupted,
)
from pbpf_drake.views.local_meshcat import MakeLocalMeshcat

# The exit code where the report is there, but another file couldn't be made.
_INCOMPLETE = 3


def _parse(argv: list[str] | None) -> argparse.Namespace:
    folder = data_folder("diagrams")
    parser = argparse.ArgumentParser(
        prog="pbpf-track",
        description="Tracks the objects of a recorded manipulation and "
        "writes report.json, errors.csv, errors.png, diagnostics.png, "
        "estimates.mcap, overlay.mp4 and replay.html.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--log", type=Path, default=folder / "logs" / "cheezit_1.mcap",
        help="MCAP file, ROS 1 bag, or ROS 2 bag or its "
        "folder")  # fmt: skip
    add("--scene", type=Path, default=folder / "scenes" / "cheezit_1.yaml",
        help="YAML file of the scene")  # fmt: skip
    add("--method", choices=METHODS, default="pbpf-v",
        help="the estimator; DOPE alone is run beside it")  # fmt: skip
    add("--particles", type=int,
        help="number of particles (default: the scene's, 150 for "
        "cvpf)")  # fmt: skip
    add("--seed", type=int, help="of all randomness (default: the scene's)")
    add("--threads", type=int, default=os.cpu_count(),
        help="so many processes share the particles; results don't depend "
        "on it")  # fmt: skip
    add("--inspect", type=Path, metavar="LOG",
        help="only say what is in this log, what of it is used, and what is "
        "missing")  # fmt: skip
    add("--show", action="store_true",
        help="show the run in Meshcat, at an address that only this machine "
        "can reach")  # fmt: skip
    add("--out", type=Path, default=Path("pbpf_out"),
        help="folder to write to")  # fmt: skip
    return parser.parse_args(argv)


def _config(args: argparse.Namespace, scene: Scene) -> ParticleFilterConfig:
    config = replace(
        DefaultConfig(scene, args.method), parallelism=args.threads
    )
    if args.particles is not None:
        config = replace(config, num_particles=args.particles)
    if args.seed is not None:
        config = replace(config, seed=args.seed)
    config.ValidateOrThrow()
    return config


def _track(
    scene: Scene,
    log: Log,
    method: str,
    config: ParticleFilterConfig,
    meshcat: Meshcat | None,
) -> TrackRecord:
    with tqdm(total=NumSteps(log, config), desc=method, unit="update") as bar:
        return Track(
            scene=scene,
            log=log,
            method=method,
            config=config,
            meshcat=meshcat,
            on_step=bar.update,
        )


def _track_all(
    args: argparse.Namespace,
    scene: Scene,
    log: Log,
    config: ParticleFilterConfig,
) -> tuple[list[TrackRecord], bool]:
    """Runs the method and DOPE; tells if an interruption ended that."""
    records: list[TrackRecord] = []
    meshcat = MakeLocalMeshcat() if args.show else None
    try:
        for method in dict.fromkeys((args.method, "dope")):
            records.append(_track(scene, log, method, config, meshcat))
            meshcat = None
    except TrackInterrupted as interruption:
        return [*records, interruption.record], True
    except KeyboardInterrupt:
        if not records:
            raise
        return records, True
    return records, False


def _say(written: WrittenOutputs, usage: Sequence[UsageRow]) -> None:
    """Prints what came out, and what was left out."""
    for warning in written.report["warnings"]:
        print(f"Warning: {warning}")
    if table := FormatUsage(usage):
        print(table)
    print(FormatTable(written.report))


def run(args: argparse.Namespace) -> tuple[str, ...]:
    """Does the main job; see _parse for the arguments.

    Returns:
        A sentence for each of the files that couldn't be made.

    Raises:
        ValueError, FileNotFoundError: an argument, the scene or the log can't
            be used; the message says why.
        KeyboardInterrupt: an interruption; what there was by then is written.
    """
    scene = LoadScene(args.scene)
    model = MakePredictionModel(scene)
    names, facts = model.joint_names, model.facts
    if args.inspect:
        look = partial(InspectLog, scene=scene, joint_names=names, facts=facts)
        print(look(filename=args.inspect))
        return ()
    config = _config(args, scene)
    log = ReadLog(
        filename=args.log, scene=scene, joint_names=names, facts=facts
    )
    if NumSteps(log, config) < 1:
        raise ValueError(
            f"{args.log} is {log.duration:.3g} s long; expected at least one "
            f"period of the filter, {config.period:g} s"
        )
    args.out.mkdir(parents=True, exist_ok=True)
    records, interrupted = _track_all(args, scene, log, config)
    tracked = TrackedLog(
        scene=scene,
        log=log,
        filename=args.log,
        config=config,
        records=records,
        usage=usage_rows(log, records[0]),
        warnings=model.warnings + log.warnings + usage_warnings(records[0]),
        interrupted=interrupted,
    )
    written = WriteOutputs(tracked, args.out)
    _say(written, tracked.usage)
    print(f"Written to {args.out.resolve()}")
    if interrupted:
        done, steps = len(records[0].times), NumSteps(log, config)
        print(
            f"Interrupted after {done} of {steps} updates: there are no plots, "
            "no video and no replay"
        )
        raise KeyboardInterrupt
    return written.failures


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    args = _parse(argv)
    failures: list[str] = []
    code = RunCommand("pbpf-track", lambda: failures.extend(run(args)))
    return _INCOMPLETE if failures and not code else code


if __name__ == "__main__":
    sys.exit(main())
