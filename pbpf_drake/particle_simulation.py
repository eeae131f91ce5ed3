"""One particle through the physics, for as long as the robot's path takes."""

import numpy as np
from pydrake.systems.analysis import Simulator

from pbpf_drake.contact_model import ContactModel
from pbpf_drake.prediction_pool import ResetIntegrator
from pbpf_drake.robot_links import LinkMotion


def simulate(
    model: ContactModel,
    simulator: Simulator,
    *,
    poses: np.ndarray,
    velocities: np.ndarray,
    links: LinkMotion,
    time_step: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Returns where the objects of a particle go, (K, 7) and (K, 6).

    Args:
        model: the contact model.
        simulator: of the contact model, with the particle's θ.
        poses: (K, 7) of the objects at the start.
        velocities: (K, 6) then: angular, translational.
        links: the motion of the model's links.
        time_step: of the physics (in seconds).
    """
    nq = model.diagram.plant().num_positions()
    x = np.zeros(nq + model.diagram.plant().num_velocities())
    x[model.object_q] = poses
    x[nq + model.object_v] = velocities
    context = simulator.get_mutable_context()
    context.SetTime(0.0)
    for s, link_velocities in enumerate(links.velocities):
        x[model.link_q] = links.poses[s]
        x[nq + model.link_v] = link_velocities
        context.SetContinuousState(x)
        if s == 0:
            ResetIntegrator(simulator, time_step)
            simulator.Initialize()
        simulator.AdvanceTo(links.times[s + 1], interruptible=False)
        x = context.get_continuous_state_vector().CopyToVector()
    return x[model.object_q], x[nq + model.object_v]


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
    """
    return np.clip(
        max_travel / np.maximum(speed, 1e-9), max_step / 16, max_step
    )
