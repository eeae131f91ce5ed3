"""MuJoCo as a motion model; left out where it isn't installed."""

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
import pytest
from recording_fixtures import SCENES
from sliding_fixtures import GRAVITY, slide

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.benchmark.mujoco_peer import MuJoCoPeer, make_mjcf
from pbpf_drake.diagrams.benchmark.peer_scene import ReadPeerScene
from pbpf_drake.motion.physical_parameters import PhysicalParameters
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import AddSceneModels

mujoco = pytest.importorskip(
    "mujoco", reason='needs MuJoCo: pip install "pbpf_drake[peers]"'
)


@pytest.fixture(scope="module")
def scene():
    return LoadScene(SCENES / "cheezit_gelatin_soup.yaml")


@pytest.fixture(scope="module")
def model(scene):
    return MakePredictionModel(scene)


def _make(scene, model, num_particles, num_threads=1) -> MuJoCoPeer:
    return MuJoCoPeer(
        scene=ReadPeerScene(scene),
        joint_names=model.joint_names,
        num_particles=num_particles,
        num_threads=num_threads,
    )


def test_the_robot_is_the_scenes(scene):
    model = mujoco.MjModel.from_xml_string(make_mjcf(ReadPeerScene(scene)))
    data = mujoco.MjData(model)
    plant = MultibodyPlant(0.0)
    robot = AddSceneModels(plant, scene).robot
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q = np.random.default_rng(2).uniform(-1, 1, plant.num_positions(robot))
    joints = [plant.get_joint(j) for j in plant.GetJointIndices(robot)]
    joints = [joint for joint in joints if joint.num_positions() > 0]
    for joint, position in zip(joints, q, strict=True):
        data.qpos[model.joint(joint.name()).qposadr[0]] = position
    plant.SetPositions(context, robot, q)
    mujoco.mj_kinematics(model, data)
    for name in ("panda_link4", "panda_hand", "panda_rightfinger"):
        X_WB = plant.GetFrameByName(name).CalcPoseInWorld(context)
        found = data.body(name)
        X = RigidTransform(RotationMatrix(found.xmat.reshape(3, 3)), found.xpos)
        assert X.IsNearlyEqualTo(X_WB, 1e-6), name


def test_an_objects_friction_is_that_of_its_contacts(scene, model):
    """Sliding distances are v²/2μg, or vt - μgt²/2."""
    friction, speed, time = np.array([0.1, 0.3]), 0.3, 0.16
    motion = slide(model, [speed, 0.0, 0.0], 2)
    dut = _make(scene, model, 2)
    dut.Prepare(PhysicalParameters(friction[:, None], 0.4, 50.0))
    poses = dut.Update(motion)
    dut.Close()
    time = np.minimum(time, speed / (friction * GRAVITY))
    expected = speed * time - friction * GRAVITY * time**2 / 2
    moved = poses[..., 4] - motion.poses[..., 4]
    for k in range(3):
        np.testing.assert_allclose(moved[:, k], expected, rtol=0.1)


def test_threads_and_earlier_updates_change_nothing(scene, model):
    motion = slide(model, [0.2, 0.0, 0.0], 4)
    other = slide(model, [-0.1, 0.1, 0.0], 4)
    theta = PhysicalParameters(0.2, 0.4, 50.0)
    single, double = _make(scene, model, 4), _make(scene, model, 4, 2)
    single.Prepare(theta)
    double.Prepare(theta)
    double.Update(other)
    np.testing.assert_array_equal(single.Update(motion), double.Update(motion))
    single.Close()
    double.Close()


def test_a_heavy_object_takes_a_light_one_with_it(scene, model):
    """The cracker box slides into the gelatin box, 10 mm ahead, on ice."""
    motion = slide(model, [[0, 0.3, 0], [0, 0, 0], [0, 0, 0]], 2)
    dut = _make(scene, model, 2)
    heavy, light = 1.5, 0.1
    mass = np.array([[heavy, light, light], [light, heavy, heavy]])
    dut.Prepare(PhysicalParameters(0.001, mass, 50.0))
    moved = (dut.Update(motion) - motion.poses)[..., 5]
    dut.Close()
    assert moved[0, 1] > 0.02
    assert 0 < moved[1, 1] < 0.3 * moved[0, 1]
    assert moved[0, 0] > moved[1, 0]
