"""The prediction of noisy particles, as the filter makes it."""

from dataclasses import replace

import numpy as np
from particle_cloud import Cloud
from physics_fixtures import (
    PROBE_RADIUS,
    TOUCHING,
    make_model,
    straight_path,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.trajectories import PiecewisePolynomial
from recording_fixtures import SCENES

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.motion.physics_motion_model import PhysicsMotionModel
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import AddSceneModels
from pbpf_drake.truth.push_path import ActuatedJoints, MakeJointTrajectory

PERIOD = 0.16
# Speed of the probe, as in the recorded pushes, and of the arm's hand, as in
# the paper's (in m/s).
PROBE_SPEED = 0.05
HAND_SPEED = 0.023
HALF_BLOCK = np.array([0.045, 0.045, 0.0065])
STEP = ParticleFilterConfig().time_step
HALF_STEP = STEP / 2
FINE_STEP = 5e-4
# What the first particles have to settle, and what is compared.
WARM_UP, COMPARED = 4, 2


def _probe_path(step: int) -> ControlPath:
    """The shipped scene's push along x; it begins just before the block."""
    start = 0.2 - HALF_BLOCK[0] - PROBE_RADIUS - 0.002
    x = start + PERIOD * PROBE_SPEED * step
    return straight_path([x, 0.0], [PROBE_SPEED, 0.0])


def _hand_paths(scene, model):
    """Returns the hand's push along y, by step; it begins at the box."""
    plant = MultibodyPlant(time_step=1e-3)
    models = AddSceneModels(plant, scene)
    plant.Finalize()
    points = np.array([[0.0, 0.045, 0.01], [0.0, 0.045 + 0.046, 0.01]])
    trajectory = MakeJointTrajectory(
        plant=plant,
        robot=models.robot,
        end_effector=scene.recording.path.end_effector,
        translation=PiecewisePolynomial.FirstOrderHold(
            [0.0, 0.046 / HAND_SPEED], points.T
        ),
    )
    names = [
        plant.get_joint(j).name() for j in ActuatedJoints(plant, models.robot)
    ]
    rows = [names.index(name) for name in model.joint_names]

    def path(step: int) -> ControlPath:
        times = PERIOD * (step + np.linspace(0.0, 1.0, 9))
        q = np.hstack([trajectory.value(t) for t in times]).T
        return ControlPath(times, q[:, rows])

    return path


def _distance(poses: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Between poses (n, 7): meters and radians, (2, n)."""
    return np.array(
        [
            np.linalg.norm(poses[:, 4:] - others[:, 4:], axis=1),
            quaternions.angle_between(poses[:, :4], others[:, :4]),
        ]
    )


def _compare(model, path, num_particles: int) -> dict[float, np.ndarray]:
    """Returns the errors (2, n) of a cloud's predictions, by time step."""
    config = ParticleFilterConfig(num_particles=num_particles)
    cloud = Cloud(model, config, path(0).positions[0])
    for step in range(WARM_UP):
        cloud.update(path(step))
    duts = {
        time_step: PhysicsMotionModel(
            model=model, config=replace(config, time_step=time_step)
        )
        for time_step in (FINE_STEP, HALF_STEP, STEP)
    }
    scratches = {t: dut.MakeScratch() for t, dut in duts.items()}
    errors = {time_step: [] for time_step in (HALF_STEP, STEP)}
    for step in range(WARM_UP, WARM_UP + COMPARED):
        motion = cloud.motion(path(step))
        poses = {
            t: dut.Propagate(motion, scratches[t]).poses[:, 0]
            for t, dut in duts.items()
        }
        moved, _ = _distance(motion.poses[:, 0], poses[FINE_STEP])
        # Most particles are pushed; noise has put the others out of reach.
        assert np.mean(moved > 1e-3) > 0.6
        for time_step, found in errors.items():
            found.append(_distance(poses[time_step], poses[FINE_STEP]))
        cloud.update(path(step))
    return {t: np.concatenate(found, axis=1) for t, found in errors.items()}


def _share(errors: np.ndarray) -> float:
    """Of the particles within 1 mm and 0.01 rad."""
    return np.mean((errors[0] < 1e-3) & (errors[1] < 1e-2))


# What goes wrong with longer steps are blocks without friction (43 % of the
# paper's distribution) that have just been hit: they spin off.
def _check(errors: dict[float, np.ndarray]) -> None:
    assert _share(errors[HALF_STEP]) >= 0.98
    assert _share(errors[STEP]) >= 0.95
    for distance, angle in errors.values():
        assert np.median(distance) < 1e-4
        assert np.median(angle) < 1e-3


def test_a_pushed_block_follows_a_fine_step_reference():
    model = MakePredictionModel(LoadScene(SCENES / "planar_push.yaml"))
    _check(_compare(model, _probe_path, num_particles=70))


def test_a_box_pushed_by_a_hand_follows_a_fine_step_reference():
    scene = LoadScene(SCENES / "cheezit_1.yaml")
    model = MakePredictionModel(scene)
    _check(_compare(model, _hand_paths(scene, model), num_particles=40))


def _lowest(poses: np.ndarray) -> np.ndarray:
    """Height of the lowest corner of each block, (M,)."""
    q, p = poses[:, 0, :4], poses[:, 0, 4:]
    down = quaternions.rotate(quaternions.conjugate(q), [0.0, 0.0, 1.0])
    return p[:, 2] - np.abs(down) @ HALF_BLOCK


def test_a_cloud_with_noise_in_all_directions_stays_on_the_table():
    """25 updates with 5 mm of noise, and a probe that pushes."""
    model = make_model("block")
    cloud = Cloud(model, ParticleFilterConfig(num_particles=70), TOUCHING)
    for step in range(25):
        path = straight_path(
            TOUCHING + [step * PERIOD * PROBE_SPEED, 0.0], [PROBE_SPEED, 0.0]
        )
        result = cloud.update(path, in_space=True)
        assert not np.any(result.failed)
        assert np.all(np.isfinite(result.poses))
        speed = np.linalg.norm(result.velocities[:, 0, 3:], axis=1)
        assert np.max(speed) < 1.0
        # A block that falls is noticed up to a step late; then it is lifted.
        assert np.min(_lowest(result.poses)) > -1e-2
        assert np.min(_lowest(cloud.poses)) > -3e-4
        assert np.max(_lowest(cloud.poses)) < 2.5e-2
    spread = np.std(cloud.poses[:, 0, 4:], axis=0)
    assert np.all(spread < [0.05, 0.05, 0.005])
