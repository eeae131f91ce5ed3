"""The physics-based motion model of PBPF (Section 4.1).

x̄ = f_θ(x, u): every particle has a context of the contact model that was
cloned with a θ of its own; links and objects are set, and physics runs.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from pbpf_drake import quaternions
from pbpf_drake.bounding_boxes import MakeBoundingBoxes
from pbpf_drake.contact_model import ContactModel, MakeContactModel
from pbpf_drake.fixed_contacts import FixedContacts
from pbpf_drake.link_reach import link_distances
from pbpf_drake.motion_model import MotionInput, MotionResult
from pbpf_drake.parameter_bank import DrawParameterBank, deal_parameters
from pbpf_drake.particle_filter_config import ParticleFilterConfig
from pbpf_drake.particle_simulation import (
    MakeParticleSimulator,
    choose_time_step,
    make_states,
    simulate,
    split_states,
)
from pbpf_drake.penetration import TOUCH, PenetrationResolver
from pbpf_drake.penetration_check import PenetrationCheck
from pbpf_drake.physical_parameters import (
    PhysicalParameters,
    SetPhysicalParameters,
)
from pbpf_drake.prediction_model import PredictionModel
from pbpf_drake.prediction_pool import Links, PredictionPool
from pbpf_drake.robot_links import LinkMotion, RobotLinks
from pbpf_drake.support import find_supports

# A link that stays further away than this from where an object can be is not
# simulated (in meters).
_REACH = 0.01
# Where objects wait that are not tracked yet: out of everybody's way.
_PARKING_HEIGHT = 1e3
_PARKING_SPACING = 1e2


@dataclass
class PhysicsScratch:
    """Work space of the motion model.

    Attributes:
        kinematics: a context of the prediction model's plant.
        pool: the simulators.
    """

    kinematics: Context
    pool: PredictionPool


class PhysicsMotionModel:
    """Predicts particles by simulating them.

    Writing θ into a context takes longer than simulating the particle. So M
    draws of θ are written once, when their contexts are made, and each step
    deals them out to the particles anew, by a random permutation: every
    particle gets a fresh θ of the same distribution at every step.

    Of the robot, only the links that come near the objects are simulated.
    """

    def __init__(
        self, *, model: PredictionModel, config: ParticleFilterConfig
    ) -> None:
        self._model = model
        self._config = config
        self._links = RobotLinks(model=model)
        self._objects = MakeBoundingBoxes(
            model.diagram.scene_graph().model_inspector(),
            [model.geometries(body) for body in model.models.objects],
        )
        self._radii = self._objects.radii(len(model.models.objects))
        self._contacts = FixedContacts(model)
        self._check = PenetrationCheck(model=model, contacts=self._contacts)
        self._contact_models: dict[Links, ContactModel] = {}
        self._parameters = DrawParameterBank(config, len(model.models.objects))

    def parameters(self) -> PhysicalParameters:
        """Returns the M draws of θ, arrays (M, K)."""
        return self._parameters

    def assignment(self, step: int) -> np.ndarray:
        """Returns which draw each particle has at a step, (M,)."""
        return deal_parameters(self._config, step)

    def MakeScratch(self) -> PhysicsScratch:
        """Returns an empty pool; its contexts are made when first used."""
        return PhysicsScratch(
            kinematics=self._model.diagram.plant().CreateDefaultContext(),
            pool=PredictionPool(
                make=self._MakeSimulator, num_threads=self._config.num_threads
            ),
        )

    def Propagate(
        self, motion: MotionInput, scratch: PhysicsScratch
    ) -> MotionResult:
        """Returns f_θ(x_{t-1}, u_t); see MotionModel."""
        links = self._links.Motion(motion.path, scratch.kinematics)
        speeds = self._Speeds(motion)
        margin = _REACH + links.travel + speeds * links.times[-1]
        velocities = np.where(motion.active[:, None], motion.velocities, 0.0)
        steps = choose_time_step(
            np.maximum(speeds, links.speed),
            max_travel=self._config.max_travel,
            max_step=self._config.time_step,
        )
        poses = self._Park(motion.poses, motion.active)
        end = np.full_like(poses, np.nan), np.full_like(velocities, np.nan)
        distances = self._Distances(
            motion.poses, motion.active, links.poses, margin
        )
        everyone = np.ones(len(poses), dtype=bool)
        for chosen, members in _groups(distances, everyone):
            end[0][members], end[1][members] = self._Simulate(
                chosen,
                scratch.pool,
                poses=poses[members],
                velocities=velocities[members],
                links=links.of(chosen),
                time_steps=steps[members],
                draws=self.assignment(motion.step)[members],
            )
        return self._Result(motion, *end)

    def ResolvePenetration(
        self,
        poses: np.ndarray,
        supports: np.ndarray,
        robot_positions: np.ndarray,
        active: np.ndarray,
        scratch: PhysicsScratch,
    ) -> np.ndarray:
        """Pushes the objects out of what they penetrate; see MotionModel."""
        link_poses = self._links.Poses(robot_positions, scratch.kinematics)
        distances = self._Distances(
            poses, active, link_poses[None], np.full(len(poses), _REACH)
        )
        deep = (distances < -TOUCH).any(axis=1)
        deep |= self._check.MayPenetrate(poses, active)
        resolved, parked = poses.copy(), self._Park(poses, active)
        for chosen, members in _groups(distances, deep):
            model = self._ContactModel(chosen)
            simulator = scratch.pool.Simulators(chosen).Get(0)
            resolver = PenetrationResolver(
                model, simulator.get_mutable_context()
            )
            num_positions = model.diagram.plant().num_positions()
            q = np.zeros((len(members), num_positions))
            q[:, model.link_q] = link_poses[list(chosen)]
            q[:, model.object_q] = parked[members]
            free = resolver.PushOut(q, supports[members])[:, model.object_q]
            resolved[np.ix_(members, active)] = free[:, active]
        return resolved

    def _Distances(
        self,
        poses: np.ndarray,
        active: np.ndarray,
        link_poses: np.ndarray,
        margin: np.ndarray,
    ) -> np.ndarray:
        return link_distances(
            objects=self._objects,
            poses=poses,
            active=active,
            links=self._links.boxes,
            link_poses=link_poses,
            margin=margin,
        )

    def _Speeds(self, motion: MotionInput) -> np.ndarray:
        """Returns the highest speed of any corner of a particle, (M,)."""
        velocities = motion.velocities[:, motion.active]
        spin = np.linalg.norm(velocities[..., :3], axis=-1)
        speed = np.linalg.norm(velocities[..., 3:], axis=-1)
        corners = speed + spin * self._radii[motion.active]
        return corners.max(axis=1, initial=0.0)

    def _Simulate(
        self,
        chosen: Links,
        pool: PredictionPool,
        *,
        poses: np.ndarray,
        velocities: np.ndarray,
        links: LinkMotion,
        time_steps: np.ndarray,
        draws: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns where m particles go, (m, K, 7) and (m, K, 6).

        Both are NaN where the simulation failed.
        """
        model, simulators = self._ContactModel(chosen), pool.Simulators(chosen)
        states = make_states(
            model, poses=poses, velocities=velocities, links=links
        )

        def simulate_one(m: int) -> None:
            try:
                states[m] = simulate(
                    model,
                    simulators.Get(draws[m]),
                    state=states[m],
                    links=links,
                    time_step=time_steps[m],
                )
            # The solver gave up on this particle; Drake's own assertions are
            # of the second type. What it left behind must not be used again.
            except (RuntimeError, SystemExit):
                simulators.Discard(draws[m])
                states[m] = np.nan

        pool.Run(simulate_one, range(len(states)))
        return split_states(model, states)

    def _Result(
        self, motion: MotionInput, poses: np.ndarray, velocities: np.ndarray
    ) -> MotionResult:
        """Returns the result, in which what failed has its old pose."""
        active = motion.active[:, None]
        finite = np.isfinite(poses).all(axis=(1, 2))
        finite &= np.isfinite(velocities).all(axis=(1, 2))
        speed = np.linalg.norm(velocities[..., 3:], axis=-1)
        with np.errstate(invalid="ignore"):
            fast = speed > self._config.max_speed
        failed = ~finite | fast[:, motion.active].any(axis=1)
        keep = failed[:, None, None] | ~active
        with np.errstate(invalid="ignore", divide="ignore"):
            poses[..., :4] = quaternions.normalize(poses[..., :4])
        poses = np.where(keep, motion.poses, poses)
        contacts = self._contacts.Find(np.where(keep, np.nan, poses))
        return MotionResult(
            poses=poses,
            velocities=np.where(keep, motion.velocities, velocities),
            supports=find_supports(contacts, *poses.shape[:2]),
            failed=failed,
        )

    def _ContactModel(self, links: Links) -> ContactModel:
        if links not in self._contact_models:
            self._contact_models[links] = MakeContactModel(self._model, links)
        return self._contact_models[links]

    def _MakeSimulator(self, links: Links, index: int) -> Simulator:
        model = self._ContactModel(links)
        context = model.diagram.CreateDefaultContext()
        for k in range(len(model.objects)):
            SetPhysicalParameters(
                model=model,
                context=context,
                k=k,
                friction=self._parameters.friction[index, k],
                mass=self._parameters.mass[index, k],
                dissipation=self._parameters.dissipation[index, k],
            )
        return MakeParticleSimulator(model, context)

    def _Park(self, poses: np.ndarray, active: np.ndarray) -> np.ndarray:
        """Returns (M, K, 7), with objects that aren't tracked yet away."""
        poses = poses.copy()
        for k in np.flatnonzero(~active):
            poses[:, k] = [1, 0, 0, 0, k * _PARKING_SPACING, 0, _PARKING_HEIGHT]
        return poses


def _groups(
    distances: np.ndarray, which: np.ndarray
) -> Iterator[tuple[Links, np.ndarray]]:
    """Yields links and the particles that they come near, then the rest.

    All that are near any link get the same links: each set of links costs
    M contexts.

    Args:
        distances: (M, L) from link_distances.
        which: (M,) the particles in question.
    """
    near = np.isfinite(distances) & which[:, None]
    chosen = tuple(int(j) for j in np.flatnonzero(near.any(axis=0)))
    reached = near.any(axis=1)
    for links, members in ((chosen, reached), ((), which & ~reached)):
        if members.any():
            yield links, np.flatnonzero(members)
