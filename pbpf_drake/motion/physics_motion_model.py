"""The physics-based motion model of PBPF (Section 4.1).

x̄ = f_θ(x, u): every particle has a context of the contact model that was
cloned with a θ of its own; links and objects are set, and physics runs.
"""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
import itertools
from typing import Any

import numpy as np
from pydrake.systems.framework import Context

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.motion.link_reach import link_distances
from pbpf_drake.motion.motion_model import MotionInput, MotionResult
from pbpf_drake.motion.parameter_bank import DrawParameterBank, deal_parameters
from pbpf_drake.motion.particle_physics import ParticlePhysics
from pbpf_drake.motion.particle_simulation import choose_time_step
from pbpf_drake.motion.penetration import TOUCH
from pbpf_drake.motion.penetration_check import PenetrationCheck
from pbpf_drake.motion.physical_parameters import PhysicalParameters
from pbpf_drake.motion.robot_links import RobotLinks
from pbpf_drake.motion.simulator_pool import Links
from pbpf_drake.motion.support import find_supports
from pbpf_drake.poses import quaternions
from pbpf_drake.process_crew import Crew
from pbpf_drake.scene.prediction_model import PredictionModel
from pbpf_drake.shapes.bounding_boxes import MakeBoundingBoxes

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
        crew: who simulates particles.
    """

    kinematics: Context
    crew: Crew


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
        self._parameters = DrawParameterBank(config, len(model.models.objects))

    def parameters(self) -> PhysicalParameters:
        """Returns the M draws of θ, arrays (M, K)."""
        return self._parameters

    def assignment(self, step: int) -> np.ndarray:
        """Returns which draw each particle has at a step, (M,)."""
        return deal_parameters(self._config, step)

    def MakeScratch(self) -> PhysicsScratch:
        """Returns a crew whose contexts are made when first used."""
        return PhysicsScratch(
            kinematics=self._model.diagram.plant().CreateDefaultContext(),
            crew=Crew(
                ParticlePhysics(self._model, self._parameters, self._contacts),
                self._config.parallelism,
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
        # Each process has the contexts of its own draws.
        draws = self.assignment(motion.step)[: len(poses)]
        for members, result in _spread(
            scratch.crew,
            ParticlePhysics.Simulate,
            lambda chosen, members: {
                "chosen": chosen,
                "poses": poses[members],
                "velocities": velocities[members],
                "links": links.of(chosen),
                "time_steps": steps[members],
                "active": motion.active,
                "max_travel": self._config.max_travel,
                "draws": draws[members],
            },
            groups=_groups(distances, everyone),
            numbers=draws,
        ):
            end[0][members], end[1][members] = result
        return self._Result(motion, *end)

    def ResolvePenetration(
        self,
        poses: np.ndarray,
        supports: np.ndarray,
        robot_positions: np.ndarray,
        known: np.ndarray,
        scratch: PhysicsScratch,
    ) -> np.ndarray:
        """Pushes the objects out of what they penetrate; see MotionModel."""
        link_poses = self._links.Poses(robot_positions, scratch.kinematics)
        distances = self._Distances(
            poses, known, link_poses[None], np.full(len(poses), _REACH)
        )
        deep = (distances < -TOUCH).any(axis=1)
        deep |= self._check.MayPenetrate(poses, known)
        resolved, parked = poses.copy(), self._Park(poses, known)
        for members, result in _spread(
            scratch.crew,
            ParticlePhysics.PushOut,
            lambda chosen, members: {
                "chosen": chosen,
                "link_poses": link_poses[list(chosen)],
                "poses": parked[members],
                "supports": supports[members],
            },
            groups=_groups(distances, deep),
            numbers=np.arange(len(poses)),
        ):
            resolved[np.ix_(members, known)] = result[:, known]
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


def _spread(
    crew: Crew,
    function: Callable[..., Any],
    arguments: Callable[[Links, np.ndarray], dict[str, Any]],
    *,
    groups: Iterable[tuple[Links, np.ndarray]],
    numbers: np.ndarray,
) -> Iterator[tuple[np.ndarray, Any]]:
    """Yields particles and what a function makes of them, all in one go.

    Args:
        crew: the processes that call it.
        function: a method of ParticlePhysics.
        arguments: returns those of links and indices of particles.
        groups: links and particles, from _groups.
        numbers: (M,) by which the particles are dealt out to the processes.
    """
    every, owners = list(groups), numbers % crew.size
    shares = [
        [
            (chosen, members[owners[members] == i])
            for chosen, members in every
            if (owners[members] == i).any()
        ]
        for i in range(crew.size)
    ]
    results = crew.Run(
        function, [[arguments(*part) for part in share] for share in shares]
    )
    for (_, members), result in zip(
        itertools.chain(*shares), itertools.chain(*results), strict=True
    ):
        yield members, result
