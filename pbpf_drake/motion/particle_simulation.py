"""One particle through the physics, for as long as the robot's path takes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
import itertools

import numpy as np
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import Context

from pbpf_drake.motion.particle_plant import ContactModel
from pbpf_drake.motion.robot_links import LinkMotion
from pbpf_drake.motion.ticks import TICK, to_ticks

# What a particle touches at first is new to it: it was disturbed, pushed out,
# and got another θ. So the first of the physics' steps is divided, at these
# shares of it.
_ONSET = (1 / 8, 3 / 8, 1)
# The steps of what falls are not shortened to less than this share.
_MIN_FALLING = 1 / 4


@dataclass(frozen=True)
class FallLimit:
    """Shortens the steps of what falls.

    Steps are chosen by how fast things are at first. Nothing but gravity makes
    them much faster within an update.

    Attributes:
        rows: where the upward velocities of the objects that count are in the
            continuous state.
        max_travel: how far they may fall in a step (in meters).
    """

    rows: Sequence[int]
    max_travel: float

    def TimeStep(self, context: Context, time_step: float) -> float:
        """Returns the step for the rest of the way (in seconds).

        Args:
            context: of the simulation, at any time.
            time_step: what it was until now, whole ticks (in seconds).
        """
        state = context.get_continuous_state_vector()
        speed = max((-state.GetAtIndex(i) for i in self.rows), default=0.0)
        if not speed * time_step > self.max_travel:  # Not a number, perhaps.
            return time_step
        step = max(self.max_travel / speed, _MIN_FALLING * time_step)
        return float(to_ticks(step))


def MakeFallLimit(
    model: ContactModel, active: np.ndarray, max_travel: float
) -> FallLimit:
    """Returns the limit for some of a model's objects.

    Args:
        model: the contact model.
        active: (K,) which of the objects count.
        max_travel: how far they may fall in a step (in meters).
    """
    rows = model.diagram.plant().num_positions() + model.object_v[active, 5]
    return FallLimit(rows=rows.tolist(), max_travel=max_travel)


def MakeParticleSimulator(model: ContactModel, context: Context) -> Simulator:
    """Returns a simulator that takes fixed steps.

    They are those of the convex solver of Drake's CENIC integrator. Error
    control costs three times as much per step, and misses contacts that
    begin within a long one.

    Args:
        model: the contact model.
        context: a root context of its diagram, with a particle's θ.
    """
    simulator = Simulator(model.diagram, context)
    ResetIntegratorFromFlags(simulator, "cenic", 1.0)
    simulator.get_mutable_integrator().set_fixed_step_mode(True)
    return simulator


def make_states(
    model: ContactModel,
    *,
    poses: np.ndarray,
    velocities: np.ndarray,
    links: LinkMotion,
) -> np.ndarray:
    """Returns the plant's state at the start of each particle, (M, nx).

    Args:
        model: the contact model.
        poses: (M, K, 7) of the objects.
        velocities: (M, K, 6): angular, translational.
        links: the motion of the model's links.
    """
    plant = model.diagram.plant()
    states = np.zeros((len(poses), plant.num_multibody_states()))
    states[:, model.object_q] = poses
    states[:, plant.num_positions() + model.object_v] = velocities
    _set_links(model, states, links, 0)
    return states


def split_states(
    model: ContactModel, states: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the objects' poses (M, K, 7) and velocities (M, K, 6)."""
    nq = model.diagram.plant().num_positions()
    return states[:, model.object_q], states[:, nq + model.object_v]


def simulate(
    model: ContactModel,
    simulator: Simulator,
    *,
    state: np.ndarray,
    links: LinkMotion,
    time_step: float,
    fall_limit: FallLimit,
) -> np.ndarray:
    """Returns the state (nx,) that a particle ends in.

    The same simulator can be used again and again; its time goes on. The
    length of a step doesn't depend on when it starts, because all times are
    whole ticks.

    Args:
        model: the contact model.
        simulator: from MakeParticleSimulator.
        state: (nx,) that it starts in.
        links: the motion of the model's links.
        time_step: of the physics (in seconds), a multiple of 8 ticks.
        fall_limit: for the steps after the first.
    """
    integrator = simulator.get_mutable_integrator()
    integrator.set_maximum_step_size(time_step)
    context = simulator.get_mutable_context()
    start = context.get_time()
    for s, (begin, end) in enumerate(itertools.pairwise(links.times.tolist())):
        if s > 0:
            _set_links(model, state, links, s)
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
    """Returns the physics' step for what moves at a speed (in seconds).

    Contacts are found at the beginning of a step, so nothing may move far
    within one.

    Args:
        speed: the highest of anything's (in m/s).
        max_travel: that it may travel in a step (in meters).
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


def _set_links(
    model: ContactModel, states: np.ndarray, links: LinkMotion, s: int
) -> None:
    """Writes where the links are, and go, into states (..., nx)."""
    nq = model.diagram.plant().num_positions()
    states[..., model.link_q] = links.poses[s]
    if len(links.velocities):
        states[..., nq + model.link_v] = links.velocities[s]
