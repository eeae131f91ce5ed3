"""What the filter makes of the shipped log, from before the box is hidden."""

from dataclasses import fields, replace

import numpy as np
from pydrake.systems.analysis import Simulator
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.filtering.filter_state import FilterState
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log, PoseRecord
from pbpf_drake.log.pose_interpolation import interpolate_poses
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.tracking_diagram import (
    DefaultConfig,
    MakeTrackingDiagram,
    NumSteps,
    Track,
)

FOLDER = data_folder("diagrams")
# Of these 9.5 s all but the first 1.3 s are without detections.
START, END = 10.5, 20.0
HALF_BOX = np.array([0.16, 0.21344, 0.061]) / 2


def _cut(log: Log, start: float, end: float) -> Log:
    """Returns the log from a time, which becomes 0, to another."""
    joints, truth = log.joints, log.ground_truth["cracker"]
    keep = (joints.times >= start) & (joints.times <= end)
    seen = (truth.times >= start) & (truth.times <= end)
    return replace(
        log,
        joints=replace(
            joints,
            times=joints.times[keep] - start,
            positions=joints.positions[keep],
            velocities=joints.velocities[keep],
        ),
        detections=tuple(
            replace(d, time=d.time - start, received=d.received - start)
            for d in log.detections
            if start <= d.time <= end
        ),
        ground_truth={
            "cracker": PoseRecord(
                times=truth.times[seen] - start,
                q_WO=truth.q_WO[seen],
                p_WO=truth.p_WO[seen],
            )
        },
    )


@pytest.fixture(scope="module")
def scene():
    return LoadScene(FOLDER / "scenes" / "cheezit_1.yaml")


@pytest.fixture(scope="module")
def log(scene):
    names = MakePredictionModel(scene).joint_names
    filename = FOLDER / "logs" / "cheezit_1.mcap"
    log = ReadLog(filename=filename, scene=scene, joint_names=names)
    return _cut(log, START, END)


def _states(scene, log, method: str) -> dict[str, np.ndarray]:
    """Returns poses, velocities and estimates after each update."""
    config = replace(DefaultConfig(scene, method), parallelism=2)
    tracking = MakeTrackingDiagram(
        scene=scene, log=log, method=method, config=config
    )
    simulator = Simulator(tracking.diagram)
    simulator.Initialize()
    context = tracking.estimator.GetMyContextFromRoot(simulator.get_context())
    groups = [field.name for field in fields(FilterState)]
    rows = {"poses": [], "velocities": [], "estimates": []}
    for step in range(1, NumSteps(log, config) + 1):
        simulator.AdvanceTo((step + 0.5) * config.period)
        for name, states in rows.items():
            group = context.get_discrete_state(groups.index(name))
            states.append(group.value().copy())
    shapes = {"poses": (-1, 7), "velocities": (-1, 6), "estimates": (2, 7)}
    return {
        name: np.array(states).reshape(len(states), *shapes[name])
        for name, states in rows.items()
    }


@pytest.fixture(scope="module", params=["pbpf", "pbpf-v"])
def states(request, scene, log):
    return _states(scene, log, request.param)


def test_no_particle_is_in_the_table(states):
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    poses = states["poses"][:, :, None]
    corners = quaternions.rotate(poses[..., :4], signs * HALF_BOX)
    heights = corners[..., 2] + poses[..., 6]
    assert heights.shape[1:] == (70, 8)
    assert heights.min() > -0.005


def test_no_particle_is_shot_away(states):
    speed = np.linalg.norm(states["velocities"][..., 3:], axis=-1)
    assert 0.01 < speed.max() < 2.0
    # Also what noise and resolved penetration add to the motion.
    away = states["poses"][..., 4:] - states["estimates"][:, :1, 4:]
    assert np.linalg.norm(away, axis=-1).max() < 0.3


def test_the_hidden_box_is_tracked_better_than_by_holding(states, scene, log):
    dope = Track(scene=scene, log=log, method="dope")
    _, p_WO = interpolate_poses(log.ground_truth["cracker"], dope.times)

    def error(positions: np.ndarray) -> float:
        return np.mean(np.linalg.norm(positions - p_WO, axis=1))

    assert dope.detected[:, 0].mean() < 0.15
    held = error(dope.poses[:, 0, 4:])
    assert held > 0.05
    assert error(states["estimates"][:, 0, 4:]) < 0.5 * held
