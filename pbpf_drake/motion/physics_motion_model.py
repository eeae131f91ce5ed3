"""The physics-based motion model of PBPF (Section 4.1).

x̄ = f_θ(x, u): each particle has a θ, which is in a context of its own. The
links of the robot and the objects are put where they are, and physics runs.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.systems.framework import Context

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.motion.link_reach import link_distances
from pbpf_drake.motion.motion_model import MotionInput, MotionResult
from pbpf_drake.motion.parameter_bank import DrawParameterBank, deal_parameters
from pbpf_drake.motion.particle_groups import deal_out, group_by_links
from pbpf_drake.motion.particle_jobs import (
    PushOutJob,
    RunOnCrew,
    SimulatedParticles,
    SimulationJob,
)
from pbpf_drake.motion.particle_physics import ParticlePhysics
from pbpf_drake.motion.particle_simulation import choose_time_step
from pbpf_drake.motion.penetration import TOUCH
from pbpf_drake.motion.penetration_check import PenetrationCheck
from pbpf_drake.motion.physical_parameters import PhysicalParameters
from pbpf_drake.motion.robot_links import LinkMotion, RobotLinks
from pbpf_drake.motion.support import find_supports
from pbpf_drake.poses import quaternions
from pbpf_drake.process_crew import Crew
from pbpf_drake.scene.prediction_model import PredictionModel
from pbpf_drake.shapes.bounding_boxes import MakeBoundingBoxes

# A link is simulated only if it comes at least this near to where an object can
# be (in meters).
_REACH = 0.01
# Objects that are not tracked yet wait up here, this far apart, out of the way
# of everything (in meters).
_PARKING_HEIGHT = 1e3
_PARKING_SPACING = 1e2


@dataclass
class PhysicsScratch:
    """Work space of the motion model.

    Attributes:
        kinematics: a context of the prediction model's plant.
        crew: the processes that simulate particles.
    """

    kinematics: Context
    crew: Crew[ParticlePhysics]


class PhysicsMotionModel:
    """Predicts particles by simulating them.

    It takes longer to write θ into a context than to simulate the particle. So
    M draws of θ are written once, when their contexts are made. At each step
    they are dealt out to the particles anew, by a random permutation: every
    particle gets another θ of the same distribution at every step.

    Only those links of the robot are simulated that come near the objects.
    """

    def __init__(
        self, *, model: PredictionModel, config: ParticleFilterConfig
    ) -> None:
        self._model = model
        self._config = config
        self._robot_links = RobotLinks(model=model)
        self._object_boxes = MakeBoundingBoxes(
            model.diagram.scene_graph().model_inspector(),
            [model.geometries(body) for body in model.models.objects],
        )
        self._radii = self._object_boxes.radii(len(model.models.objects))
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
        """Returns work space, most of which is made when first used."""
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
        link_motion = self._robot_links.Motion(motion.path, scratch.kinematics)
        speeds = self._Speeds(motion)
        distances = self._LinkDistances(
            motion.poses,
            motion.active,
            link_motion.poses,
            _REACH + link_motion.travel + speeds * link_motion.times[-1],
        )
        job = self._MakeSimulationJob(motion, link_motion, speeds)
        end = SimulatedParticles(
            poses=np.full_like(job.poses, np.nan),
            velocities=np.full_like(job.velocities, np.nan),
        )
        groups = group_by_links(distances, np.ones(len(job.poses), dtype=bool))
        # Each process has the contexts of its own draws.
        shares = deal_out(groups, job.draws, scratch.crew.size)
        for members, result in RunOnCrew(scratch.crew, shares, job.of):
            end.poses[members] = result.poses
            end.velocities[members] = result.velocities
        return self._MakeResult(motion, end)

    def ResolvePenetration(
        self,
        poses: np.ndarray,
        supports: np.ndarray,
        robot_positions: np.ndarray,
        known: np.ndarray,
        scratch: PhysicsScratch,
    ) -> np.ndarray:
        """Pushes the objects out of what they penetrate; see MotionModel."""
        link_poses = self._robot_links.Poses(
            robot_positions, scratch.kinematics
        )
        distances = self._LinkDistances(
            poses, known, link_poses[None], np.full(len(poses), _REACH)
        )
        deep = (distances < -TOUCH).any(axis=1)
        deep |= self._check.MayPenetrate(poses, known)
        job = PushOutJob(
            link_set=tuple(range(len(link_poses))),
            link_poses=link_poses,
            poses=self._Park(poses, known),
            supports=supports,
        )
        resolved = poses.copy()
        shares = deal_out(
            group_by_links(distances, deep),
            np.arange(len(poses)),
            scratch.crew.size,
        )
        for members, result in RunOnCrew(scratch.crew, shares, job.of):
            resolved[np.ix_(members, known)] = result[:, known]
        return resolved

    def _MakeSimulationJob(
        self, motion: MotionInput, link_motion: LinkMotion, speeds: np.ndarray
    ) -> SimulationJob:
        """Returns the job of all particles, with all links.

        Args:
            motion: from which the particles start.
            link_motion: of all links.
            speeds: (M,) from _Speeds.
        """
        return SimulationJob(
            link_set=tuple(range(link_motion.poses.shape[1])),
            link_motion=link_motion,
            poses=self._Park(motion.poses, motion.active),
            velocities=np.where(motion.active[:, None], motion.velocities, 0.0),
            active=motion.active,
            time_steps=choose_time_step(
                np.maximum(speeds, link_motion.speed),
                max_travel=self._config.max_travel,
                max_step=self._config.time_step,
            ),
            max_travel=self._config.max_travel,
            draws=self.assignment(motion.step)[: len(motion.poses)],
        )

    def _LinkDistances(
        self,
        poses: np.ndarray,
        active: np.ndarray,
        link_poses: np.ndarray,
        margin: np.ndarray,
    ) -> np.ndarray:
        return link_distances(
            object_boxes=self._object_boxes,
            poses=poses,
            active=active,
            link_boxes=self._robot_links.boxes,
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

    def _MakeResult(
        self, motion: MotionInput, end: SimulatedParticles
    ) -> MotionResult:
        """Returns the result, in which what failed is as it was before."""
        poses, velocities = end.poses, end.velocities
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
        """Returns poses (M, K, 7) in which untracked objects are far away."""
        poses = poses.copy()
        for k in np.flatnonzero(~active):
            poses[:, k] = [1, 0, 0, 0, k * _PARKING_SPACING, 0, _PARKING_HEIGHT]
        return poses
