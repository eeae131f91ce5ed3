import numpy as np
from physics_fixtures import (
    FLAT,
    HEIGHTS,
    PROBE_RADIUS,
    Simulation,
    link_motion,
    make_model,
    straight_path,
    wall_at,
)
from pydrake.common.eigen_geometry import Quaternion
import pytest
from recording_fixtures import SCENES

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.motion.robot_links import RobotLinks
from pbpf_drake.motion.ticks import to_ticks
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.prediction_model import MakePredictionModel

# The wall's face is at x = 0.1.
AT_WALL = 0.1 - 0.045
TOUCHING = AT_WALL - 0.045 - PROBE_RADIUS


@pytest.fixture(scope="module")
def panda():
    return MakePredictionModel(LoadScene(SCENES / "cheezit_1.yaml"))


@pytest.fixture(scope="module")
def probe():
    return make_model("block")


def _coast(motion, duration: float) -> np.ndarray:
    """Where links get that keep their first velocity, (L, 7)."""
    q, p = motion.poses[0, :, :4], motion.poses[0, :, 4:]
    v = duration * motion.velocities[0]
    turn = quaternions.from_rotation_vector(v[:, :3])
    return np.concatenate([quaternions.multiply(turn, q), p + v[:, 3:]], axis=1)


def _assert_same_poses(found, expected, tolerance: float) -> None:
    np.testing.assert_allclose(found[:, 4:], expected[:, 4:], atol=tolerance)
    angle = quaternions.angle_between(found[:, :4], expected[:, :4])
    np.testing.assert_allclose(angle, 0.0, atol=tolerance)


def test_poses_are_those_of_the_arms_kinematics(panda):
    plant = panda.diagram.plant()
    context, other = (plant.CreateDefaultContext() for _ in range(2))
    for q in np.random.default_rng(0).uniform(-2, 2, (5, 9)):
        poses = RobotLinks(model=panda).Poses(q, context)
        plant.SetPositions(other, panda.models.robot, q)
        for pose, link in zip(poses, panda.links, strict=True):
            X_WL = plant.EvalBodyPoseInWorld(other, plant.get_body(link))
            np.testing.assert_allclose(pose[4:], X_WL.translation())
            R = Quaternion(pose[:4]).rotation()
            np.testing.assert_allclose(R, X_WL.rotation().matrix(), atol=1e-12)


def test_a_straight_motion_is_one_piece(probe):
    motion = link_motion(probe, straight_path([0.1, 0.2], [0.03, -0.04]))
    np.testing.assert_allclose(motion.times, to_ticks([0.0, 0.16]))
    np.testing.assert_allclose(motion.poses[:, 0, 4], [0.1, 0.1048])
    np.testing.assert_allclose(
        motion.velocities[0, 0], [0, 0, 0, 0.03, -0.04, 0], atol=1e-12
    )
    assert motion.speed == pytest.approx(0.05)
    assert motion.travel == pytest.approx(0.008)


def test_travel_is_a_way_there_and_back(probe):
    path = ControlPath(
        np.array([1, 2, 4]), np.array([[0, 0], [0.2, 0], [0, 0]])
    )
    motion = link_motion(probe, path)
    assert motion.travel == pytest.approx(0.4)
    assert motion.speed == pytest.approx(0.2)


def test_a_robot_at_rest_does_not_move(panda):
    motion = link_motion(panda, straight_path(np.full(9, 0.1), np.zeros(9)))
    assert len(motion.times) == 2
    assert motion.speed == motion.travel == 0.0
    np.testing.assert_allclose(motion.velocities, 0.0, atol=1e-12)


@pytest.mark.parametrize("speed", [0.05, 0.5, 2.0])
def test_every_part_of_an_arm_is_near_where_the_joints_put_it(panda, speed):
    rng = np.random.default_rng(1)
    q = rng.uniform(-1, 1, 9) + speed * 0.16 * np.sin(
        np.linspace(0.0, 1.5, 9)[:, None] * rng.uniform(0.5, 2, 9)
    )
    path = ControlPath(np.linspace(3.0, 3.16, 9), q)
    links = RobotLinks(model=panda)
    context = panda.diagram.plant().CreateDefaultContext()
    motion = links.Motion(path, context)
    for time, positions in zip(path.times - 3.0, path.positions, strict=True):
        s = min(np.searchsorted(motion.times, time), len(motion.times) - 1)
        s = max(s - 1, 0)
        piece = motion.of(range(len(panda.links)))
        pose = _coast(
            type(piece)(
                motion.times[s:], motion.poses[s:], motion.velocities[s:], 0, 0
            ),
            time - motion.times[s],
        )
        found = links.boxes.at(pose).corners()
        expected = links.boxes.at(links.Poses(positions, context)).corners()
        # Corners are on an arc between two poses, not on the chord.
        assert np.max(np.linalg.norm(found - expected, axis=-1)) < 1.5e-3


def test_some_of_the_links_are_a_part_of_all(panda):
    motion = link_motion(panda, straight_path(np.zeros(9), np.full(9, 0.3)))
    some = motion.of((8, 10))
    np.testing.assert_array_equal(some.poses, motion.poses[:, [8, 10]])
    np.testing.assert_array_equal(
        some.velocities, motion.velocities[:, [8, 10]]
    )


def test_links_coast_in_the_air_whatever_their_speed(panda):
    rng = np.random.default_rng(0)
    simulation = Simulation(panda)
    simulation.set_pose(FLAT, [3.0, 0.0, 1.0])
    for _ in range(5):
        q, v = rng.uniform(-1, 1, (2, 9))
        simulation.set_robot(q, v)
        simulation.advance(0.16)
        motion = link_motion(panda, straight_path(q, v, samples=2))
        _assert_same_poses(simulation.links(), _coast(motion, 0.16), 2e-5)


@pytest.mark.parametrize("mass", [0.1, 1.0, 5.0])
def test_a_probe_is_not_slowed_down_by_what_it_pushes(mass):
    simulation = Simulation(make_model("block"), friction=0.8, mass=mass)
    simulation.settle(FLAT, [AT_WALL, 0.0, HEIGHTS["block"]])
    start, speed = np.array([TOUCHING - 0.002, 0.01]), np.array([0.1, 0.02])
    simulation.set_robot(start, speed)
    before = simulation.links()
    simulation.advance(0.16)
    expected = before + [[0, 0, 0, 0, *(0.16 * speed), 0]]
    _assert_same_poses(simulation.links(), expected, 1e-5)
    assert simulation.pose()[4] > AT_WALL + 0.01


def test_a_probe_is_not_slowed_down_by_what_it_jams_against_a_wall():
    model = make_model("block", fixed=wall_at(0.1))
    simulation = Simulation(model, friction=0.8, mass=1.0)
    simulation.settle(FLAT, [AT_WALL - 1e-4, 0.0, HEIGHTS["block"]])
    start, speed = np.array([TOUCHING - 1e-4, 0.0]), np.array([0.02, 0.0])
    simulation.set_robot(start, speed)
    before = simulation.links()
    simulation.advance(0.16)
    # 3 mm too little room: 90 N for each of the two corners at the wall.
    expected = before + [[0, 0, 0, 0, *(0.16 * speed), 0]]
    _assert_same_poses(simulation.links(), expected, 1e-5)
