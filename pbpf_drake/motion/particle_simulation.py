"""Simulates one particle for as long as the robot's path takes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import itertools

import numpy as np
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Context

from pbpf_drake.motion.particle_plant import ParticlePlant
from pbpf_drake.motion.robot_links import LinkMotion
from pbpf_drake.motion.ticks import TICK, to_ticks

# A particle's first contacts are new to it: it has just got noise, was pushed
# out, and got another θ. So the first step of the physics is divided into
# shorter ones, which end at these shares of it.
_ONSET = (1 / 8, 3 / 8, 1)
# When something falls, steps are not shortened to less than this share.
_MIN_FALLING = 1 / 4


@dataclass(frozen=True)
class FallLimit:
    """Shortens the steps when an object falls.

    Steps are chosen by how fast things are at first. Within an update nothing
    but gravity makes them much faster.

    Attributes:
        rows: where the continuous state has the upward velocities of the
            objects that count.
        max_travel: how far they may fall in a step (in meters).
    """

    rows: Sequence[int]
    max_travel: float

    def TimeStep(self, context: Context, time_step: float) -> float:
        """Returns the step for the rest of the way (in seconds).

        Args:
            context: of the simulation, at any time.
            time_step: the step until now, in whole ticks (in seconds).
        """
        state = context.get_continuous_state_vector()
        speed = max((-state.GetAtIndex(i) for i in self.rows), default=0.0)
        if not speed * time_step > self.max_travel:  # Not a number, perhaps.
            return time_step
        step = max(self.max_travel / speed, _MIN_FALLING * time_step)
        return float(to_ticks(step))


def MakeFallLimit(
    particle_plant: ParticlePlant, active: np.ndarray, max_travel: float
) -> FallLimit:
    """Returns the limit for some of the plant's objects.

    Args:
        particle_plant: what particles are simulated in.
        active: (K,) which of the objects count.
        max_travel: how far they may fall in a step (in meters).
    """
    rows = (
        particle_plant.diagram.plant().num_positions()
        + particle_plant.object_v[active, 5]
    )
    return FallLimit(rows=rows.tolist(), max_travel=max_travel)


def MakeParticleSimulator(
    particle_plant: ParticlePlant, context: Context
) -> Simulator:
    """Returns a simulator that takes fixed steps.

    The steps are those of the convex solver of Drake's CENIC integrator. With
    error control a step would cost three times as much, and a contact that
    begins within a long step would be missed.

    Args:
        particle_plant: what particles are simulated in.
        context: a root context of its diagram, with a particle's θ.
    """
    simulator = Simulator(particle_plant.diagram, context)
    ResetIntegratorFromFlags(simulator, "cenic", 1.0)
    simulator.get_mutable_integrator().set_fixed_step_mode(True)
    return simulator


def make_states(
    particle_plant: ParticlePlant,
    *,
    poses: np.ndarray,
    velocities: np.ndarray,
    link_motion: LinkMotion,
) -> np.ndarray:
    """Returns the plant's state at the start of each particle, (M, nx).

    Args:
        particle_plant: what particles are simulated in.
        poses: (M, K, 7) of the objects.
        velocities: (M, K, 6): angular, translational.
        link_motion: how the plant's links move.
    """
    plant = particle_plant.diagram.plant()
    states = np.zeros((len(poses), plant.num_multibody_states()))
    states[:, particle_plant.object_q] = poses
    states[:, plant.num_positions() + particle_plant.object_v] = velocities
    _write_links(particle_plant, states, link_motion, 0)
    return states


def split_states(
    particle_plant: ParticlePlant, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the objects' poses (M, K, 7) and velocities (M, K, 6)."""
    nq = particle_plant.diagram.plant().num_positions()
    velocities = states[:, nq + particle_plant.object_v]
    return states[:, particle_plant.object_q], velocities


def simulate(
    particle_plant: ParticlePlant,
    simulator: Simulator,
    *,
    state: np.ndarray,
    link_motion: LinkMotion,
    time_step: float,
    fall_limit: FallLimit,
) -> np.ndarray:
    """Returns the state (nx,) that a particle ends in.

    The same simulator can be used again and again; its time goes on. The
    length of a step doesn't depend on when it starts, because all times are
    whole ticks.

    Args:
        particle_plant: what particles are simulated in.
        simulator: from MakeParticleSimulator.
        state: (nx,) that the particle starts in.
        link_motion: how the plant's links move.
        time_step: of the physics (in seconds), a multiple of 8 ticks.
        fall_limit: for the steps after the first.
    """
    integrator = simulator.get_mutable_integrator()
    integrator.set_maximum_step_size(time_step)
    context = simulator.get_mutable_context()
    start = context.get_time()
    for s, (begin, end) in enumerate(
        itertools.pairwise(link_motion.times.tolist())
    ):
        if s > 0:
            _write_links(particle_plant, state, link_motion, s)
        context.SetContinuousState(state)
        for time in _ends(begin, end, time_step):
            simulator.AdvanceTo(start + time, interruptible=False)
            if time == time_step:
                integrator.set_maximum_step_size(
                    fall_limit.TimeStep(context, time_step)
                )
        state = context.get_continuous_state_vector().CopyToVector()
    return state


def choose_time_step(
    speed: np.ndarray, *, max_travel: float, max_step: float
) -> np.ndarray:
    """Returns the physics' step for things of some speed (in seconds).

    Contacts are found at the beginning of a step, so nothing may move far
    within one.

    Args:
        speed: the speed of whatever moves fastest (in m/s).
        max_travel: how far that may move in a step (in meters).
        max_step: the longest step (in seconds); none is below a 16th of it.

    Returns:
        The steps, in whole multiples of 8 ticks.
    """
    step = np.clip(
        max_travel / np.maximum(speed, 1e-9), max_step / 16, max_step
    )
    return np.maximum(8 * to_ticks(step / 8), 8 * TICK)


def _ends(begin: float, end: float, time_step: float) -> Iterator[float]:
    """Yields the times after begin, up to end, at which steps have to end."""
    for share in _ONSET:
        if begin < share * time_step < end:
            yield share * time_step
    if begin < end:
        yield end


def _write_links(
    particle_plant: ParticlePlant,
    states: np.ndarray,
    link_motion: LinkMotion,
    s: int,
) -> None:
    """Writes the links' poses and velocities of piece s into states."""
    nq = particle_plant.diagram.plant().num_positions()
    states[..., particle_plant.link_q] = link_motion.poses[s]
    if len(link_motion.velocities):
        states[..., nq + particle_plant.link_v] = link_motion.velocities[s]
