"""Scenes, simulations and clouds of particles for the tests of the physics."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from pydrake.common.yaml import yaml_load_typed

from pbpf_drake import quaternions
from pbpf_drake.contact_model import MakeContactModel
from pbpf_drake.control_path import ControlPath
from pbpf_drake.motion_model import MotionInput, MotionResult
from pbpf_drake.particle_filter_config import (
    ParticleFilterConfig,
    PhysicalParametersConfig,
    TruncatedGaussian,
)
from pbpf_drake.particle_simulation import MakeParticleSimulator
from pbpf_drake.physical_parameters import (
    SetPhysicalParameters,
)
from pbpf_drake.physics_motion_model import PhysicsMotionModel
from pbpf_drake.pose_noise import add_process_noise
from pbpf_drake.prediction_model import MakePredictionModel, PredictionModel
from pbpf_drake.robot_links import LinkMotion, RobotLinks
from pbpf_drake.scene import Scene
from pbpf_drake.ticks import to_ticks

GRAVITY = 9.81
FLAT = np.array([1.0, 0.0, 0.0, 0.0])
# The can's axis is its y axis.
CAN_UPRIGHT = quaternions.from_rotation_vector(np.array([np.pi / 2, 0, 0]))
# How high their centres are when they rest on the table.
HEIGHTS = {"cracker": 0.0305, "gelatin": 0.01395, "soup": 0.05, "block": 0.0065}
PROBE_RADIUS = 0.004745
# The probe touches a block at the origin.
TOUCHING = np.array([-0.045 - PROBE_RADIUS, 0.0])
# Here it touches none.
AWAY = np.array([-0.7, 0.7])

_WORLD = """
directives:
- add_model: {name: table, file: package://pbpf_drake/table/table.sdf}
- add_weld: {parent: world, child: table::table}
- add_model:
    name: pusher
    file: package://pbpf_drake/planar_push/pusher.urdf
- add_weld: {parent: world, child: pusher::pusher_base}
"""


def wall_at(x: float) -> str:
    """Returns directives for a wall whose face is at x."""
    return f"""
- add_model:
    name: wall
    file: package://pbpf_drake/obstacles/scene_4_support.sdf
- add_weld:
    parent: world
    child: wall::scene_4_support
    X_PC: {{translation: [{x + 0.1035}, 0.0, 0.08405]}}
"""


def make_scene(
    tracked: Mapping[str, str],
    *,
    fixed: str = "",
    last: str = "",
    folder: str = "",
) -> Scene:
    """Returns a table, the planar pusher's probe, and tracked objects.

    Args:
        tracked: the model files by the names of the objects.
        fixed: more directives.
        last: directives after the objects'.
        folder: what package://scene stands for.
    """
    text = _WORLD + fixed
    for name, file in tracked.items():
        text += f"- add_model: {{name: {name}, file: '{file}'}}\n"
    text += last
    names = ", ".join(f"{name}: {{}}" for name in tracked)
    text += f"robot: pusher\ntracked: {{{names}}}\n"
    scene = yaml_load_typed(schema=Scene, data=text)
    scene.path = f"{folder}/scene.yaml" if folder else ""
    return scene


def make_model(*names: str, fixed: str = "") -> PredictionModel:
    """Returns the prediction model of make_scene with shipped objects."""
    folders = {"block": "planar_push"}
    files = {
        name: f"package://pbpf_drake/{folders.get(name, name)}/{name}.sdf"
        for name in names
    }
    return MakePredictionModel(make_scene(files, fixed=fixed))


class Simulation:
    """A context of a contact model with all links, the probe out of the way.

    Args:
        model: the prediction model.
        time_step: of the integrator (in seconds).
        parameters: friction, mass and dissipation of all objects.
    """

    def __init__(
        self, model: PredictionModel, *, time_step: float = 0.01, **parameters
    ) -> None:
        self.model = model
        self.contact = MakeContactModel(model, range(len(model.links)))
        self._time_step = time_step
        self.context = self.contact.diagram.CreateDefaultContext()
        self.simulator = MakeParticleSimulator(self.contact, self.context)
        self.plant = self.contact.diagram.plant()
        self.plant_context = self.plant.GetMyMutableContextFromRoot(
            self.context
        )
        self._kinematics = model.diagram.plant().CreateDefaultContext()
        for k in range(len(model.models.objects)):
            self.set_parameters(k, **parameters)
        if len(model.robot_q) == 2:
            self.set_robot(AWAY, [0.0, 0.0])

    def set_parameters(
        self, k, *, friction=0.3, mass=0.4, dissipation=100.0
    ) -> None:
        SetPhysicalParameters(
            model=self.contact,
            context=self.context,
            k=k,
            friction=friction,
            mass=mass,
            dissipation=dissipation,
        )

    def _set(self, kind: str, indices: np.ndarray, values) -> None:
        x = getattr(self.plant, f"Get{kind}")(self.plant_context)
        x[indices] = values
        getattr(self.plant, f"Set{kind}")(self.plant_context, x)

    def set_robot(self, q, v) -> None:
        """Puts the links where the joints are, moving as the joints do."""
        path = straight_path(np.array(q), v, samples=2)
        links = RobotLinks(model=self.model).Motion(path, self._kinematics)
        self._set("Positions", self.contact.link_q, links.poses[0])
        self._set("Velocities", self.contact.link_v, links.velocities[0])

    def set_pose(self, q_WO, p_WO, k: int = 0) -> None:
        self._set("Positions", self.contact.object_q[k], [*q_WO, *p_WO])

    def set_velocity(self, velocity, k: int = 0) -> None:
        self._set("Velocities", self.contact.object_v[k], velocity)

    def settle(self, q_WO, p_WO, duration: float = 0.3, k: int = 0) -> None:
        """Sets an object down, to rest."""
        self.set_pose(q_WO, p_WO, k)
        self.advance(duration)

    def advance(self, duration: float) -> None:
        integrator = self.simulator.get_mutable_integrator()
        integrator.set_maximum_step_size(to_ticks(self._time_step))
        self.simulator.AdvanceTo(
            self.context.get_time() + to_ticks(duration), interruptible=False
        )

    def links(self) -> np.ndarray:
        q = self.plant.GetPositions(self.plant_context)
        return q[self.contact.link_q]

    def pose(self, k: int = 0) -> np.ndarray:
        q = self.plant.GetPositions(self.plant_context)
        return q[self.contact.object_q[k]]

    def velocity(self, k: int = 0) -> np.ndarray:
        v = self.plant.GetVelocities(self.plant_context)
        return v[self.contact.object_v[k]]


def straight_path(start, velocity, *, duration=0.16, samples=9) -> ControlPath:
    """Returns a robot's straight motion at a steady speed."""
    times = np.linspace(0.0, duration, samples)
    return ControlPath(times, start + np.outer(times, velocity))


def link_motion(model: PredictionModel, path: ControlPath) -> LinkMotion:
    """Returns how the robot's links move while its joints follow a path."""
    context = model.diagram.plant().CreateDefaultContext()
    return RobotLinks(model=model).Motion(path, context)


def make_motion(poses, velocities, path, *, step=1, active=None) -> MotionInput:
    """Returns an input of a motion model that ignores the estimates."""
    num_objects = poses.shape[1]
    if active is None:
        active = np.ones(num_objects, dtype=bool)
    return MotionInput(
        poses=poses,
        velocities=velocities,
        active=active,
        path=path,
        estimates=np.tile(poses[0], (2, 1, 1)),
        num_estimates=np.zeros(num_objects, dtype=int),
        step=step,
    )


def exactly(**values: float) -> PhysicalParametersConfig:
    """Returns a θ that is the same for all particles."""
    config = PhysicalParametersConfig()
    for name, value in values.items():
        gaussian = TruncatedGaussian(mean=value, stddev=0.0, min=1e-3)
        config = replace(config, **{name: gaussian})
    return config


def blocks_on_table(num_particles: int) -> np.ndarray:
    """Blocks at rest on the table, (M, 1, 7)."""
    poses = np.tile([*FLAT, 0.0, 0.0, HEIGHTS["block"]], (num_particles, 1, 1))
    return poses


def blocks_in_the_way(num_particles: int, seed: int = 0) -> np.ndarray:
    """Blocks in the way of the probe, anywhere within 10 mm, (M, 1, 7)."""
    rng = np.random.default_rng(seed)
    poses = blocks_on_table(num_particles)
    poses[:, 0, 4:6] += rng.uniform(0.0, 0.01, (num_particles, 2))
    return poses


def still(poses: np.ndarray) -> np.ndarray:
    """Returns velocities of 0 for poses (M, K, 7)."""
    return np.zeros((*poses.shape[:2], 6))


def assert_same(
    first: MotionResult, second: MotionResult, rows=slice(None)
) -> None:
    """Fails unless two results are identical to the bit."""
    for name in ("poses", "velocities", "supports", "failed"):
        np.testing.assert_array_equal(
            getattr(first, name)[rows], getattr(second, name)[rows]
        )


class Cloud:
    """Particles that go through the filter's motion update, again and again.

    They start at the scene's own poses, with the process noise of objects on
    a table.

    Args:
        model: the prediction model.
        config: of the filter.
        robot: (n,) where the robot starts.
    """

    def __init__(
        self,
        model: PredictionModel,
        config: ParticleFilterConfig,
        robot: np.ndarray,
    ) -> None:
        self.motion_model = PhysicsMotionModel(model=model, config=config)
        self.scratch = self.motion_model.MakeScratch()
        self.config = config
        self.step = 0
        self._rng = np.random.default_rng(0)
        shape = (config.num_particles, *model.nominal_poses.shape)
        self.poses = np.broadcast_to(model.nominal_poses, shape)
        self.velocities = np.zeros((*shape[:2], 6))
        upwards = np.tile([0.0, 0.0, 1.0], (*shape[:2], 1))
        self._disturb(upwards, robot)

    def motion(self, path: ControlPath) -> MotionInput:
        """Returns what the motion model gets for the next update."""
        return make_motion(
            self.poses, self.velocities, path, step=self.step + 1
        )

    def update(
        self, path: ControlPath, *, in_space: bool = False
    ) -> MotionResult:
        """Predicts, adds noise, and resolves penetration.

        Args:
            path: the robot's.
            in_space: whether noise ignores what the objects stand on.

        Returns:
            The prediction, before the noise.
        """
        result = self.motion_model.Propagate(self.motion(path), self.scratch)
        self.step += 1
        self.poses, self.velocities = result.poses, result.velocities
        supports = 0.0 * result.supports if in_space else result.supports
        self._disturb(supports, path.positions[-1])
        return result

    def _disturb(self, supports: np.ndarray, robot: np.ndarray) -> None:
        noisy = add_process_noise(
            self.poses, self.config.process_noise, self._rng, supports
        )
        self.poses = self.motion_model.ResolvePenetration(
            noisy,
            supports,
            robot,
            np.ones(noisy.shape[1], dtype=bool),
            self.scratch,
        )
