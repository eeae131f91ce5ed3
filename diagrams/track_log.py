"""Tracks the objects of a recorded manipulation: the main job.

Without arguments it tracks the log that comes with pbpf_drake: a cracker box
that is pushed behind an obstacle. See --help for everything else.
"""

import argparse
from dataclasses import replace
import os
from pathlib import Path
import sys

from pydrake.geometry import Meshcat, MeshcatParams
from tqdm import tqdm

from pbpf_drake.config.particle_filter_config import (
    METHODS,
    ParticleFilterConfig,
)
from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.log.camera_images import CameraImages
from pbpf_drake.log.log_inspection import InspectLog
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.results.diagnostic_plot import PlotDiagnostics
from pbpf_drake.results.error_plot import PlotErrors
from pbpf_drake.results.report import (
    FormatTable,
    MakeReport,
    WriteErrors,
    WriteReport,
)
from pbpf_drake.results.track_diagnostics import MakeDiagnostics
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.tracking_diagram import DefaultConfig, NumSteps, Track
from pbpf_drake.tracking.write_track import WriteTrack
from pbpf_drake.views.scene_meshcat import SaveReplay


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
    meshcat: Meshcat | None = None,
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


def _write_track(
    args: argparse.Namespace, scene: Scene, log: Log, record: TrackRecord
) -> tuple[str, ...]:
    """Writes what viewers open; returns warnings on the camera's images."""
    images = CameraImages(
        filename=args.log,
        topic=scene.topics.images,
        camera=scene.camera,
        start_time=log.start_time,
    )
    WriteTrack(
        scene=scene,
        log=log,
        record=record,
        images=images.At(record.times),
        mcap_filename=args.out / "estimates.mcap",
        video_filename=args.out / "overlay.mp4",
    )
    return images.Warnings()


def run(args: argparse.Namespace) -> None:
    """Does the main job; see _parse for the arguments.

    Raises:
        ValueError, FileNotFoundError: an argument, the scene or the log can't
            be used; the message says why.
    """
    scene = LoadScene(args.scene)
    model = MakePredictionModel(scene)
    if args.inspect:
        text = InspectLog(
            filename=args.inspect,
            scene=scene,
            joint_names=model.joint_names,
            facts=model.facts,
        )
        print(text)
        return
    config = _config(args, scene)
    log = ReadLog(
        filename=args.log,
        scene=scene,
        joint_names=model.joint_names,
        facts=model.facts,
    )
    if NumSteps(log, config) < 1:
        raise ValueError(
            f"{args.log} is {log.duration:.3g} s long; expected at least one "
            f"period of the filter, {config.period:g} s"
        )
    args.out.mkdir(parents=True, exist_ok=True)
    meshcat = Meshcat(MeshcatParams(show_stats_plot=False))
    meshcat.StartRecording(set_visualizations_while_recording=False)
    records = [_track(scene, log, args.method, config, meshcat=meshcat)]
    if args.method != "dope":
        records.append(_track(scene, log, "dope", config))
    warnings = model.warnings + log.warnings
    warnings += _write_track(args, scene, log, records[0])
    report = MakeReport(records, log.ground_truth, warnings)
    WriteReport(report, args.out / "report.json")
    WriteErrors(records, log.ground_truth, args.out / "errors.csv")
    PlotErrors(records, log.ground_truth, args.out / "errors.png")
    diagnostics = MakeDiagnostics(
        scene=scene, joints=log.joints, record=records[0], config=config
    )
    PlotDiagnostics(
        records[0], diagnostics, log.ground_truth, args.out / "diagnostics.png"
    )
    SaveReplay(meshcat, args.out / "replay.html")
    for warning in warnings:
        print(f"Warning: {warning}")
    print(FormatTable(report))
    print(f"Written to {args.out.resolve()}")


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    args = _parse(argv)
    return RunCommand("pbpf-track", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
