"""Draws what a scene's camera sees of a log, with estimates as wireframes.

The image is rendered from the ground truth. The estimate is green, and the
last detection is yellow, as in Fig. 1 of the paper.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
import sys

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
import numpy as np
from pydrake.math import RigidTransform

from pbpf_drake.config.camera_config import CameraConfig
from pbpf_drake.config.particle_filter_config import METHODS
from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.diagrams.pictures.camera_view import CameraView
from pbpf_drake.log.joint_log_source import interpolate_joints
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.log.pose_interpolation import interpolate_poses
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.results.track_record import TrackRecord
from pbpf_drake.scene.pinhole import in_camera, project_points
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.tracking_diagram import SceneOfLog, Track
from pbpf_drake.views.palette import DETECTION_BGR, ESTIMATE_BGR


def _parse(argv: list[str] | None) -> argparse.Namespace:
    folder = data_folder("diagrams")
    parser = argparse.ArgumentParser(
        description=__doc__.splitlines()[0],
        formatter_class=argparse.ArgumentDefaultsHelpFormatter,
    )
    add = parser.add_argument
    add("--log", type=Path, default=folder / "logs" / "cheezit_1.mcap",
        help="MCAP file of ROS 2 messages, with ground truth")  # fmt: skip
    add("--scene", type=Path, default=folder / "scenes" / "cheezit_1.yaml",
        help="YAML file of the scene")  # fmt: skip
    add("--method", choices=METHODS, default="pbpf-v", help="the estimator")
    add("--times", type=float, nargs="+", default=[4.0, 15.2, 23.5],
        help="when to look, in seconds")  # fmt: skip
    add("--out", type=Path, default=Path("camera_views.png"),
        help="picture to write")  # fmt: skip
    return parser.parse_args(argv)


def _true_poses(scene: Scene, log: Log, time: float) -> list[RigidTransform]:
    poses = []
    for name in scene.object_names():
        if name not in log.ground_truth:
            raise ValueError(
                f"the log has no ground truth of {name!r}; expected one of "
                "every tracked object, to draw it there"
            )
        q, p = interpolate_poses(log.ground_truth[name], np.array([time]))
        poses.append(rigid_transform(np.append(q, p)))
    return poses


def _draw_boxes(
    ax: Axes,
    view: CameraView,
    camera: CameraConfig,
    poses: np.ndarray,
    color: np.ndarray,
) -> None:
    for k, pose in enumerate(poses):
        X_WO = rigid_transform(pose)
        p_W = view.BoxEdges(k) @ X_WO.rotation().matrix().T
        p_C = in_camera(p_W + X_WO.translation(), camera)
        for line in project_points(p_C, camera):
            ax.plot(*line.T, lw=1.5, color=color)


def _draw_view(
    ax: Axes,
    view: CameraView,
    scene: Scene,
    log: Log,
    records: Sequence[TrackRecord],
    time: float,
) -> None:
    q, _ = interpolate_joints(log.joints, time)
    ax.imshow(view.Render(q, _true_poses(scene, log, time)))
    step = int(np.argmin(np.abs(records[0].times - time)))
    for record in records:
        bgr = DETECTION_BGR if record.method == "dope" else ESTIMATE_BGR
        color = np.flip(bgr) / 255
        _draw_boxes(ax, view, scene.camera, record.poses[step], color)
    detected = np.all(records[0].detected[step])
    ax.set_title(f"{time:.1f} s, {'' if detected else 'not '}detected")
    ax.set_xlim(-0.5, scene.camera.width - 0.5)
    ax.set_ylim(scene.camera.height - 0.5, -0.5)
    ax.set_axis_off()


def run(args: argparse.Namespace) -> None:
    """Tracks the log and draws the picture; see _parse for the arguments."""
    scene = LoadScene(args.scene)
    model = MakePredictionModel(scene)
    log = ReadLog(
        filename=args.log,
        scene=scene,
        joint_names=model.joint_names,
        facts=model.facts,
    )
    scene = SceneOfLog(scene, log)
    records = [
        Track(scene=scene, log=log, method=method)
        for method in dict.fromkeys(("dope", args.method))
    ]
    view = CameraView(scene)
    figure = Figure(figsize=(4.0 * len(args.times), 3.3), dpi=100)
    FigureCanvasAgg(figure)
    figure.set_layout_engine("constrained")
    axes = figure.subplots(1, len(args.times), squeeze=False)[0]
    for ax, time in zip(axes, args.times, strict=True):
        _draw_view(ax, view, scene, log, records, time)
    figure.savefig(args.out)


def main(argv: list[str] | None = None) -> int:
    """Runs the script; returns its exit code."""
    args = _parse(argv)
    return RunCommand("draw_camera_views", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
