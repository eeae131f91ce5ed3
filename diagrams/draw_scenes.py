"""Draws what the cameras of scenes see at some times of their logs.

A row per scene; the images are rendered from the ground truth.
"""

import argparse
from pathlib import Path
import sys

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
import numpy as np

from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.diagrams.pictures.camera_view import CameraView
from pbpf_drake.log.joint_log_source import interpolate_joints
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.log.pose_interpolation import interpolate_poses
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder

# When to look, as shares of a log's duration.
_TIMES = (0.05, 0.35, 0.5, 0.75)


def _parse(argv: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0],
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("logs", type=Path, nargs="+",
        help="MCAP files; a log's name is its scene's")  # fmt: skip
    add("--out", type=Path, default=Path("scenes.png"),
        help="picture to write")  # fmt: skip
    return parser.parse_args(argv)


def render_log(scene: Scene, log: Log, times: np.ndarray) -> list[np.ndarray]:
    """Returns what the camera sees at given times.

    Raises:
        ValueError: the log doesn't say where an object was.
    """
    missing = set(scene.object_names()) - set(log.ground_truth)
    if missing:
        raise ValueError(f"the log has no ground truth of {sorted(missing)}")
    view = CameraView(scene)
    truths = [
        interpolate_poses(log.ground_truth[name], times)
        for name in scene.object_names()
    ]
    return [
        view.Render(
            interpolate_joints(log.joints, time)[0],
            [rigid_transform(np.hstack([q[i], p[i]])) for q, p in truths],
        )
        for i, time in enumerate(times)
    ]


def run(args: argparse.Namespace) -> None:
    """Draws the picture; see _parse for the arguments."""
    figure = Figure(figsize=(2.5 * len(_TIMES), 2.05 * len(args.logs)), dpi=80)
    FigureCanvasAgg(figure)
    figure.set_layout_engine("constrained")
    rows = figure.subplots(len(args.logs), len(_TIMES), squeeze=False)
    for axes, filename in zip(rows, args.logs, strict=True):
        name = filename.stem
        scene = LoadScene(data_folder("diagrams") / "scenes" / f"{name}.yaml")
        names = MakePredictionModel(scene).joint_names
        log = ReadLog(filename=filename, scene=scene, joint_names=names)
        times = np.array(_TIMES) * log.duration
        for ax, time, image in zip(
            axes, times, render_log(scene, log, times), strict=True
        ):
            ax.imshow(image)
            ax.set_title(f"{name}, {time:.0f} s", fontsize=9)
            ax.set_axis_off()
    args.out.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(args.out)


def main(argv: list[str] | None = None) -> int:
    """Runs the script; returns its exit code."""
    args = _parse(argv)
    return RunCommand("draw_scenes", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
