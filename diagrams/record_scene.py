"""Simulates a scene's push and records it as a log that pbpf-track reads.

The truth is not the filter's prediction model: see truth_model.
Without arguments it records the log that comes with pbpf_drake.
"""

import argparse
from pathlib import Path
import sys

import numpy as np
from tqdm import tqdm

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.log.mcap_log_writer import WriteLog
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.truth.truth_simulation import Recording, RecordRun


def _parse(argv: list[str] | None) -> argparse.Namespace:
    scenes = data_folder("diagrams") / "scenes"
    parser = argparse.ArgumentParser(
        prog="pbpf-record",
        description="Simulates the push that the recording section of a scene "
        "describes, and writes joint states, detections and ground truth as "
        "an MCAP file.",
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--scene", type=Path, default=scenes / "cheezit_1.yaml",
        help="YAML file of the scene")  # fmt: skip
    add("--out", type=Path, default=Path("pbpf_recording.mcap"),
        help="MCAP file to write")  # fmt: skip
    add("--run", type=int, default=0,
        help="number of the run: another one has another start, path, "
        "friction, mass and detector")  # fmt: skip
    add("--duration", type=float,
        help="of the log, in seconds (default: the scene's)")  # fmt: skip
    return parser.parse_args(argv)


def _record(scene: Scene, run: int) -> Recording:
    with tqdm(
        total=scene.recording.duration,
        desc="record",
        bar_format="{l_bar}{bar}| {n:.1f}/{total:.1f} s [{elapsed}]",
    ) as bar:
        return RecordRun(
            scene=scene,
            run=run,
            progress=lambda time: bar.update(time - bar.n),
        )


def _describe_motion(truth: PoseRecord) -> str:
    """Returns how far an object is at the end from where it started."""
    way = np.linalg.norm(truth.p_WO[-1] - truth.p_WO[0])
    turn = quaternions.angle_between(truth.q_WO[0], truth.q_WO[-1])
    return f"moved by {1e3 * way:.0f} mm, turned by {np.degrees(turn):.0f} deg"


def _describe(scene: Scene, run: int, recording: Recording) -> str:
    """Returns what was recorded, line by line."""
    log, parameters = recording.log, recording.parameters
    lines = [
        f"Run {run}, {log.duration:g} s: "
        f"{len(log.joints.times)} states of {len(log.joints.names)} joints, "
        f"{len(recording.image_times)} images",
        f"friction {parameters.friction:.3f} between objects and what is "
        f"fixed, {parameters.robot_friction:.3f} of the robot",
    ]
    for k, (name, truth) in enumerate(log.ground_truth.items()):
        count = sum(d.name == name for d in log.detections)
        lines.append(
            f"{name}: {_describe_motion(truth)}; detected in "
            f"{count / len(recording.image_times):.0%} of the images; mass "
            f"{parameters.mass_scale[k]:.3f} times its model's"
        )
    return "\n".join(lines)


def run(args: argparse.Namespace) -> None:
    """Records a scene; see _parse for the arguments.

    Raises:
        ValueError, FileNotFoundError: an argument or the scene can't be used;
            the message says why.
    """
    scene = LoadScene(args.scene)
    if args.duration is not None:
        scene.recording.duration = args.duration
    scene.recording.ValidateOrThrow()
    recording = _record(scene, args.run)
    args.out.parent.mkdir(parents=True, exist_ok=True)
    WriteLog(
        filename=args.out,
        scene_topics=scene.topics,
        log=recording.log,
        class_ids={
            name: class_id for class_id, name in scene.object_by_class().items()
        },
    )
    print(_describe(scene, args.run, recording))
    print(f"Written to {args.out.resolve()}")


def main(argv: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    args = _parse(argv)
    return RunCommand("pbpf-record", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
