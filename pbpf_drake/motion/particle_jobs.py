"""What processes do with particles: simulate them, or push them out.

A job holds all that a process has to know of its particles. It is made for all
particles first; ``of`` takes the part of a group.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
import itertools
from typing import TypeVar

import numpy as np

from pbpf_drake.motion.particle_groups import ParticleGroup
from pbpf_drake.motion.particle_physics import ParticlePhysics
from pbpf_drake.motion.particle_simulation import (
    MakeFallLimit,
    make_states,
    simulate,
    split_states,
)
from pbpf_drake.motion.robot_links import LinkMotion, LinkSet
from pbpf_drake.process_crew import Crew, Job

_Result = TypeVar("_Result")


@dataclass(frozen=True)
class SimulatedParticles:
    """Where particles got to; NaN where the simulation failed.

    Attributes:
        poses: (m, K, 7) of the objects: qw qx qy qz, x y z (in meters).
        velocities: (m, K, 6) angular (rad/s), then translational (m/s).
    """

    poses: np.ndarray
    velocities: np.ndarray


@dataclass(frozen=True)
class SimulationJob:
    """Particles to simulate while the robot's links move.

    Attributes:
        link_set: the robot's links that are simulated.
        link_motion: how these L links move.
        poses: (m, K, 7) of the objects at first: qw qx qy qz, x y z (in
            meters).
        velocities: (m, K, 6) angular (rad/s), then translational (m/s).
        active: (K,) which objects count.
        time_steps: (m,) of the physics (in seconds).
        max_travel: how far what falls may travel in a step (in meters).
        draws: (m,) which draw of θ each particle has.
    """

    link_set: LinkSet
    link_motion: LinkMotion
    poses: np.ndarray
    velocities: np.ndarray
    active: np.ndarray
    time_steps: np.ndarray
    max_travel: float
    draws: np.ndarray

    def of(self, group: ParticleGroup) -> "SimulationJob":
        """Returns the job of a group, if this is that of all particles."""
        return replace(
            self,
            link_set=group.link_set,
            link_motion=self.link_motion.of(group.link_set),
            poses=self.poses[group.members],
            velocities=self.velocities[group.members],
            time_steps=self.time_steps[group.members],
            draws=self.draws[group.members],
        )

    def RunOn(self, physics: ParticlePhysics) -> SimulatedParticles:
        """Returns where the particles go."""
        particle_plant = physics.Plant(self.link_set)
        simulators = physics.Simulators(self.link_set)
        states = make_states(
            particle_plant,
            poses=self.poses,
            velocities=self.velocities,
            link_motion=self.link_motion,
        )
        fall_limit = MakeFallLimit(particle_plant, self.active, self.max_travel)
        for m, draw in enumerate(self.draws):
            try:
                states[m] = simulate(
                    particle_plant,
                    simulators.Get(draw),
                    state=states[m],
                    link_motion=self.link_motion,
                    time_step=self.time_steps[m],
                    fall_limit=fall_limit,
                )
            # The solver gave up on this particle. (Where an assertion of
            # Drake's own failed, it is a SystemExit.) The simulator may be
            # left in any state, so it must not be used again.
            except (RuntimeError, SystemExit):
                simulators.Discard(draw)
                states[m] = np.nan
        poses, velocities = split_states(particle_plant, states)
        return SimulatedParticles(poses=poses, velocities=velocities)


@dataclass(frozen=True)
class PushOutJob:
    """Particles whose objects penetrate something, perhaps.

    Attributes:
        link_set: the robot's links that count.
        link_poses: (L, 7) of these links.
        poses: (m, K, 7) of the objects: qw qx qy qz, x y z (in meters).
        supports: (m, K, 3) normals of what they stand on, or zeros.
    """

    link_set: LinkSet
    link_poses: np.ndarray
    poses: np.ndarray
    supports: np.ndarray

    def of(self, group: ParticleGroup) -> "PushOutJob":
        """Returns the job of a group, if this is that of all particles."""
        return PushOutJob(
            link_set=group.link_set,
            link_poses=self.link_poses[list(group.link_set)],
            poses=self.poses[group.members],
            supports=self.supports[group.members],
        )

    def RunOn(self, physics: ParticlePhysics) -> np.ndarray:
        """Returns the poses of the objects without penetrations, (m, K, 7)."""
        particle_plant = physics.Plant(self.link_set)
        num_positions = particle_plant.diagram.plant().num_positions()
        q = np.zeros((len(self.poses), num_positions))
        q[:, particle_plant.link_q] = self.link_poses
        q[:, particle_plant.object_q] = self.poses
        q = physics.Resolver(self.link_set).PushOut(q, self.supports)
        return q[:, particle_plant.object_q]


def RunOnCrew(
    crew: Crew[ParticlePhysics],
    shares: Sequence[Sequence[ParticleGroup]],
    job_of: Callable[[ParticleGroup], Job[ParticlePhysics, _Result]],
) -> Iterator[tuple[np.ndarray, _Result]]:
    """Yields the members of each group and what became of them.

    Args:
        crew: the processes.
        shares: the groups of each process, from deal_out.
        job_of: returns the job of a group.
    """
    results = crew.Run([[job_of(group) for group in share] for share in shares])
    for group, result in zip(
        itertools.chain(*shares), itertools.chain(*results), strict=True
    ):
        yield group.members, result
