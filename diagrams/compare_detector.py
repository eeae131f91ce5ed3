"""Compares the simulated detector with traces of the authors' real one.

A trace holds the errors of the last detection, held, at every update. The same
is computed of simulated runs: each is recorded once, and what the detector
makes of its true visibility is drawn many times. The real number should be
among the simulated ones; there is one trace per scene at most, and beside it
are the means of the paper's tables. How much of the objects the images show is
counted as well.

Traces are files cracker_scene<N>_early_DOPE_<pos|ang>_<repeat>.csv with the
columns step, time [s], error [m or rad], name, without a header.
"""

import argparse
from collections.abc import Callable, Mapping, Sequence
import csv
from functools import partial
import itertools
import os
from pathlib import Path
import sys

import numpy as np
from tqdm import tqdm

from pbpf_drake.config.detector_config import DetectorConfig
from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.diagrams.jobs.executors import LocalExecutor
from pbpf_drake.diagrams.jobs.run_command import RunCommand
from pbpf_drake.diagrams.jobs.scene_run import scene_path
from pbpf_drake.diagrams.paper.paper_values import (
    PAPER,
    SCENES,
    paper_runs_and_repeats,
)
from pbpf_drake.log.log_records import DetectionRecord, PoseRecord
from pbpf_drake.log.pose_interpolation import interpolate_poses
from pbpf_drake.poses import quaternions
from pbpf_drake.poses.pose_conversion import rigid_transform
from pbpf_drake.truth.simulated_detector import SimulatedDetector
from pbpf_drake.truth.truth_simulation import Recording, RecordRun

_QUANTILES = (0.05, 0.5, 0.95)
_COLUMNS = [
    "scene",
    "object",
    "statistic",
    "real_trace",
    "paper",
    "simulated_05",
    "simulated_50",
    "simulated_95",
]
# Time between two updates (in seconds).
_PERIOD = 0.16
# A change of the error (in meters) that no clear view has.
_JUMP = 0.03
# By how much a held pose's error changes at most, from one update to the next,
# while the object moves on at 23 mm/s (in meters, and in radians).
_DRIFT = (0.004, 0.025)
# What is further off is an outlier (in meters, and in radians).
_OUTLIER = (0.1, 0.5)
# How many updates before the first jump the view is clear no more.
_MARGIN = 6


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


def read_trace(folder: Path, scene: str) -> np.ndarray | None:
    """Returns a real run's errors, (N, 2) [m, rad], if there is a trace."""
    name = f"cracker_scene{scene.removeprefix('cheezit_')}_early_DOPE"
    files = [sorted(folder.glob(f"{name}_{k}_*.csv")) for k in ("pos", "ang")]
    if not all(files):
        return None
    # All repeats of a scene are of the same recording.
    position, angle = (
        np.loadtxt(found[-1], delimiter=",", usecols=(1, 2)) for found in files
    )
    nearest = np.abs(position[:, :1] - angle[:, 0]).argmin(axis=1)
    return np.column_stack([position[:, 1], angle[nearest, 1]])


def held_errors(
    detections: Sequence[DetectionRecord], truth: PoseRecord, scene: Scene
) -> np.ndarray:
    """Returns the errors of the last detection at every update, (N, 2).

    Args:
        detections: of one object, in order of time; at least one.
        truth: its true poses.
        scene: says where the camera is.
    """
    received = np.array([d.received for d in detections])
    updates = np.arange(_PERIOD, truth.times[-1], _PERIOD)
    updates = updates[updates >= received[0]]
    last = np.searchsorted(received, updates, side="right") - 1
    poses = [scene.camera.pose() @ d.X_CO for d in detections]
    q_WD = np.array([X.rotation().ToQuaternion().wxyz() for X in poses])
    p_WD = np.array([X.translation() for X in poses])
    q_WO, p_WO = interpolate_poses(truth, updates)
    return np.column_stack(
        [
            np.linalg.norm(p_WD[last] - p_WO, axis=1),
            quaternions.angle_between(q_WO, q_WD[last]),
        ]
    )


def is_stale(errors: np.ndarray) -> np.ndarray:
    """Returns at which updates a pose is held, as far as errors tell, (N,).

    They are in runs of at least two changes that the object's motion explains.
    Before the first jump, in a clear view, none is.

    Args:
        errors: (N, 2) [m, rad].
    """
    changes = np.abs(np.diff(errors, axis=0))
    jumps = np.flatnonzero(changes[:, 0] > _JUMP)
    small = np.all(changes < _DRIFT, axis=1)
    small[: jumps[0] if len(jumps) else len(small)] = False
    result, start = np.zeros(len(errors), dtype=bool), 1
    for value, group in itertools.groupby(small):
        length = len(list(group))
        result[start : start + length] = value and length >= 2
        start += length
    return result


def describe(errors: np.ndarray) -> dict[str, float]:
    """Returns the statistics of one run; nan where there is nothing to count.

    Args:
        errors: (N, 2) [m, rad].
    """
    changes = np.diff(errors, axis=0)
    jumps = np.flatnonzero(np.abs(changes[:, 0]) > _JUMP)
    end = max(jumps[0] - _MARGIN, 0) if len(jumps) else len(changes)
    clear = changes[_MARGIN:end] if end > 2 * _MARGIN else changes[:0]
    stale = is_stale(errors)
    is_off = (errors > _OUTLIER) & ~stale[:, np.newaxis]
    result = {"stale share": float(stale.mean())}
    for k, name in enumerate(("position", "rotation")):
        off = errors[is_off[:, k], k]
        result |= {
            f"{name}: mean": float(errors[:, k].mean()),
            f"{name}: standard deviation": float(errors[:, k].std()),
            f"{name}: share of outliers": float(is_off[:, k].mean()),
            f"{name}: outliers' median": _or_nan(np.median, off),
            f"{name}: outliers' maximum": _or_nan(np.max, off),
            f"{name}: last": float(errors[-1, k]),
            f"{name}: step noise": _or_nan(np.std, clear[:, k]),
        }
    return result


def describe_images(
    visibility: np.ndarray, config: DetectorConfig
) -> dict[str, float]:
    """Returns in which shares of a run's images an object is clear or hidden.

    Args:
        visibility: (N,) visible shares of the object.
        config: says what is clear, and what is hidden.
    """
    clear = visibility >= config.clear_visibility
    hidden = visibility < config.hidden_visibility
    return {
        "images: clear": float(clear.mean()),
        "images: partly hidden": float((~clear & ~hidden).mean()),
        "images: hidden": float(hidden.mean()),
    }


def _or_nan(
    function: Callable[[np.ndarray], float], values: np.ndarray
) -> float:
    return float(function(values)) if len(values) else np.nan


def draw_errors(
    recording: Recording, scene: Scene, seed: int
) -> dict[str, np.ndarray]:
    """Returns what another detector makes of a run: (N, 2) per object.

    An object that it never finds is left out.
    """
    truths = recording.log.ground_truth
    times = recording.image_times
    poses = [interpolate_poses(truth, times) for truth in truths.values()]
    detector = SimulatedDetector(
        config=scene.recording.detector,
        names=list(truths),
        X_WC=scene.camera.pose(),
        rng=np.random.default_rng(seed),
    )
    found: dict[str, list[DetectionRecord]] = {name: [] for name in truths}
    for i, time in enumerate(times):
        for detection in detector.Detect(
            time=time,
            poses=[rigid_transform(np.hstack([q[i], p[i]])) for q, p in poses],
            visibility=recording.visibility[i],
        ):
            found[detection.name].append(detection)
    return {
        name: held_errors(found[name], truth, scene)
        for name, truth in truths.items()
        if found[name]
    }


def _describe_run(
    scene_and_run: tuple[str, int], draws: int
) -> list[tuple[str, dict[str, float]]]:
    """Returns an object's name and statistics, for each object and draw."""
    name, run = scene_and_run
    scene = LoadScene(scene_path(name))
    recording = RecordRun(scene=scene, run=run)
    images = {
        object_name: describe_images(visibility, scene.recording.detector)
        for object_name, visibility in zip(
            recording.log.ground_truth, recording.visibility.T, strict=True
        )
    }
    return [
        (object_name, images[object_name] | describe(errors))
        for draw in range(draws)
        for object_name, errors in draw_errors(
            recording, scene, 1000 * run + draw
        ).items()
    ]


def make_rows(
    scene: str,
    object_name: str,
    simulated: Sequence[Mapping[str, float]],
    trace: np.ndarray | None,
) -> list[list]:
    """Returns a row per statistic, as _COLUMNS says."""
    real = {} if trace is None else describe(trace)
    paper = PAPER.get((scene, object_name, "dope"))
    means = (
        {"position: mean": paper.pos_mean, "rotation: mean": paper.rot_mean}
        if paper
        else {}
    )
    rows = []
    for key in simulated[0]:
        values = np.array([run[key] for run in simulated])
        values = values[np.isfinite(values)]
        quantiles = (
            np.quantile(values, _QUANTILES) if len(values) else [np.nan] * 3
        )
        numbers = [real.get(key, np.nan), means.get(key, np.nan), *quantiles]
        texts = ["" if np.isnan(x) else f"{x:.4f}" for x in numbers]
        rows.append([scene, object_name, key, *texts])
    return rows


def _print(rows: Sequence[Sequence[str]]) -> None:
    for (scene, object_name), group in itertools.groupby(
        rows, key=lambda row: (row[0], row[1])
    ):
        print(f"\n{scene}, {object_name}")
        print(f"{'':31}{'real':>8}{'paper':>8}{'simulated: 5, 50, 95 %':>27}")
        for _, _, key, real, paper, *simulated in group:
            mark = ""
            if real and all(simulated):
                low, high = float(simulated[0]), float(simulated[-1])
                mark = "" if low <= float(real) <= high else "  outside"
            numbers = "".join(f"{x:>9}" for x in simulated)
            print(f"  {key:29}{real:>8}{paper:>8}{numbers}{mark}")


def _check(args: argparse.Namespace) -> None:
    """Raises ValueError or OSError if an argument can't be used."""
    for name in "runs", "draws", "jobs":
        value = getattr(args, name)
        if value is not None and value < 1:
            raise ValueError(f"--{name} is {value}; expected at least 1")
    if not args.traces.is_dir():
        raise FileNotFoundError(f"There is no folder {args.traces}")
    if all(read_trace(args.traces, scene) is None for scene in SCENES):
        raise FileNotFoundError(
            f"There is no trace in {args.traces}; expected files as "
            "cracker_scene1_early_DOPE_pos_01.csv"
        )
    args.out.parent.mkdir(parents=True, exist_ok=True)


def run(args: argparse.Namespace) -> None:
    """Records, draws and compares; see _parse for the arguments."""
    _check(args)
    tasks = [
        (scene, run)
        for scene in args.scenes
        for run in range(args.runs or paper_runs_and_repeats(scene)[0])
    ]
    found: dict[tuple[str, str], list] = {}
    with LocalExecutor(args.jobs) as executor:
        results = executor.map(partial(_describe_run, draws=args.draws), tasks)
        for (scene, _), runs in zip(
            tasks, tqdm(results, total=len(tasks), desc="record"), strict=True
        ):
            for object_name, statistics in runs:
                found.setdefault((scene, object_name), []).append(statistics)
    rows = []
    for (scene, object_name), simulated in found.items():
        trace = read_trace(args.traces, scene)
        rows += make_rows(scene, object_name, simulated, trace)
    _print(rows)
    with open(args.out, "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(_COLUMNS)
        writer.writerows(rows)
    print(f"\nWritten to {args.out.resolve()}")


def main(argv: list[str] | None = None) -> int:
    """Runs the script; returns its exit code."""
    args = _parse(argv)
    return RunCommand("compare_detector", lambda: run(args))


if __name__ == "__main__":
    sys.exit(main())
