"""The physics-based motion model of PBPF (Section 4.1).

x̄ = f_θ(x, u): every particle has a context of the prediction model that was
cloned with a θ of its own; robot and objects are set, and physics runs.
"""

import numpy as np
from pydrake.systems.analysis import Simulator

from pbpf_drake.control_path import ControlPath, simplify_path
from pbpf_drake.motion_model import MotionInput, MotionResult
from pbpf_drake.particle_filter_config import ParticleFilterConfig
from pbpf_drake.penetration import push_out
from pbpf_drake.physical_parameters import (
    PhysicalParameters,
    SamplePhysicalParameters,
    SetPhysicalParameters,
)
from pbpf_drake.prediction_model import PredictionModel
from pbpf_drake.prediction_pool import (
    MakeSimulator,
    PredictionPool,
    ResetIntegrator,
)
from pbpf_drake.random_streams import MakeGenerator, Stream
from pbpf_drake.support import find_supports

# Corners of the robot's motion that are cut (in radians or meters).
_PATH_TOLERANCE = 5e-4
# Where objects wait that are not tracked yet: out of everybody's way.
_PARKING_HEIGHT = 1e3
_PARKING_SPACING = 1e2


class PhysicsMotionModel:
    """Predicts particles by simulating them.

    Writing θ into a context takes longer than simulating the particle. So M
    draws of θ are written once, when their contexts are made, and each step
    deals them out to the particles anew, by a random permutation: every
    particle gets a fresh θ of the same distribution at every step.
    """

    def __init__(
        self, *, model: PredictionModel, config: ParticleFilterConfig
    ) -> None:
        self._model = model
        self._config = config
        self._parameters = SamplePhysicalParameters(
            config.physics,
            (config.num_particles, len(model.models.objects)),
            MakeGenerator(
                seed=config.seed, step=0, stream=Stream.PHYSICAL_PARAMETERS
            ),
        )

    def parameters(self) -> PhysicalParameters:
        """Returns the M draws of θ, arrays (M, K)."""
        return self._parameters

    def assignment(self, step: int) -> np.ndarray:
        """Returns which draw each particle has at a step, (M,)."""
        rng = MakeGenerator(
            seed=self._config.seed,
            step=step,
            stream=Stream.PARAMETER_ASSIGNMENT,
        )
        return rng.permutation(self._config.num_particles)

    def MakeScratch(self) -> PredictionPool:
        """Returns an empty pool; its contexts are made when first used."""
        return PredictionPool(
            make=self._MakeSimulator, num_threads=self._config.num_threads
        )

    def Propagate(
        self, motion: MotionInput, scratch: PredictionPool
    ) -> MotionResult:
        """Returns f_θ(x_{t-1}, u_t); see MotionModel."""
        poses, velocities = motion.poses.copy(), motion.velocities.copy()
        supports = np.zeros((*poses.shape[:2], 3))
        failed = np.zeros(len(poses), dtype=bool)
        path = simplify_path(motion.path, _PATH_TOLERANCE)
        start = self._Positions(poses, path.positions[0], motion.active)
        speeds = np.where(motion.active[:, None], velocities, 0.0)
        draws = self.assignment(motion.step)

        def simulate(m: int) -> None:
            simulator = scratch.Simulator(draws[m])
            try:
                q, v = self._Simulate(simulator, start[m], speeds[m], path)
                self._Store(m, q, v, motion.active, poses, velocities, failed)
                if not failed[m]:
                    context = simulator.get_context()
                    supports[m] = find_supports(self._model, context)
            # The solver gave up on this particle; Drake's own assertions are
            # of the second type. What it left behind must not be used again.
            except (RuntimeError, SystemExit):
                failed[m] = True
                scratch.Discard(draws[m])

        scratch.Run(simulate, range(len(poses)))
        return MotionResult(poses, velocities, supports, failed)

    def ResolvePenetration(
        self,
        poses: np.ndarray,
        robot_positions: np.ndarray,
        active: np.ndarray,
        scratch: PredictionPool,
    ) -> np.ndarray:
        """Pushes the objects out of what they penetrate; see MotionModel."""
        context = scratch.Simulator(0).get_mutable_context()
        poses = poses.copy()
        for m, q in enumerate(self._Positions(poses, robot_positions, active)):
            free = push_out(self._model, context, q)[self._model.object_q]
            poses[m, active] = free[active]
        return poses

    def _MakeSimulator(self, index: int) -> Simulator:
        simulator = MakeSimulator(self._model, self._config.time_step)
        context = simulator.get_mutable_context()
        plant = self._model.diagram.plant()
        scene_graph = self._model.diagram.scene_graph()
        for k, body in enumerate(self._model.models.objects):
            SetPhysicalParameters(
                plant=plant,
                plant_context=plant.GetMyMutableContextFromRoot(context),
                scene_graph=scene_graph,
                scene_graph_context=scene_graph.GetMyMutableContextFromRoot(
                    context
                ),
                body=body,
                friction=self._parameters.friction[index, k],
                mass=self._parameters.mass[index, k],
                dissipation=self._parameters.dissipation[index, k],
            )
        return simulator

    def _Positions(
        self, poses: np.ndarray, robot: np.ndarray, active: np.ndarray
    ) -> np.ndarray:
        """Returns (M, nq), with objects that aren't tracked yet parked."""
        model = self._model
        q = np.zeros((len(poses), model.diagram.plant().num_positions()))
        q[:, model.robot_q] = robot
        q[:, model.object_q] = poses
        for k in np.flatnonzero(~active):
            parked = [1, 0, 0, 0, k * _PARKING_SPACING, 0, _PARKING_HEIGHT]
            q[:, model.object_q[k]] = parked
        return q

    def _Simulate(
        self,
        simulator: Simulator,
        q: np.ndarray,
        velocities: np.ndarray,
        path: ControlPath,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns q and v at the end of the path, from q and (K, 6)."""
        model, nq = self._model, len(q)
        x = np.zeros(nq + model.diagram.plant().num_velocities())
        x[:nq] = q
        x[nq + model.object_v] = velocities
        context = simulator.get_mutable_context()
        context.SetContinuousState(x)
        times = path.times - path.times[0]
        speeds = np.diff(path.positions, axis=0) / np.diff(times)[:, None]
        context.SetTime(0.0)
        for s, speed in enumerate(speeds):
            x[model.robot_q] = path.positions[s]
            x[nq + model.robot_v] = speed
            context.SetContinuousState(x)
            if s == 0:
                ResetIntegrator(simulator, self._config.time_step)
                simulator.Initialize()
            simulator.AdvanceTo(times[s + 1], interruptible=False)
            x = context.get_continuous_state_vector().CopyToVector()
        return x[:nq], x[nq:]

    def _Store(
        self,
        m: int,
        q: np.ndarray,
        v: np.ndarray,
        active: np.ndarray,
        poses: np.ndarray,
        velocities: np.ndarray,
        failed: np.ndarray,
    ) -> None:
        """Writes a simulated particle into the arrays, unless it failed."""
        pose, velocity = q[self._model.object_q], v[self._model.object_v]
        finite = np.all(np.isfinite(pose)) and np.all(np.isfinite(velocity))
        speed = np.linalg.norm(velocity[:, 3:], axis=1)
        if not finite or np.any(speed[active] > self._config.max_speed):
            failed[m] = True
            return
        pose[:, :4] /= np.linalg.norm(pose[:, :4], axis=1, keepdims=True)
        poses[m, active] = pose[active]
        velocities[m, active] = velocity[active]
