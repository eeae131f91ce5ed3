"""The physics of some of the particles, each by itself."""

import numpy as np
from pydrake.systems.analysis import Simulator

from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.motion.particle_plant import ContactModel, MakeContactModel
from pbpf_drake.motion.particle_simulation import (
    MakeFallLimit,
    MakeParticleSimulator,
    make_states,
    simulate,
    split_states,
)
from pbpf_drake.motion.penetration import PenetrationResolver
from pbpf_drake.motion.physical_parameters import (
    PhysicalParameters,
    SetPhysicalParameters,
)
from pbpf_drake.motion.robot_links import LinkMotion
from pbpf_drake.motion.simulator_pool import Links, PredictionPool
from pbpf_drake.scene.prediction_model import PredictionModel


class ParticlePhysics:
    """Contexts of the contact model with draws of θ, made when first used.

    What it returns depends on the arguments only.

    Args:
        model: the scene's models.
        parameters: the draws of θ, arrays (M, K).
        contacts: of the same scene.
    """

    def __init__(
        self,
        model: PredictionModel,
        parameters: PhysicalParameters,
        contacts: FixedContacts,
    ) -> None:
        self._model = model
        self._parameters = parameters
        self._contacts = contacts
        self._contact_models: dict[Links, ContactModel] = {}
        self._resolvers: dict[Links, PenetrationResolver] = {}
        self._pool = PredictionPool(self._MakeSimulator)

    def Simulate(
        self,
        chosen: Links,
        *,
        poses: np.ndarray,
        velocities: np.ndarray,
        links: LinkMotion,
        time_steps: np.ndarray,
        active: np.ndarray,
        max_travel: float,
        draws: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns where m particles go, (m, K, 7) and (m, K, 6).

        Both are NaN where the simulation failed.

        Args:
            chosen: the robot's links that are simulated.
            poses: (m, K, 7) of the objects.
            velocities: (m, K, 6): angular, translational.
            links: the motion of these links.
            time_steps: (m,) of the physics (in seconds).
            active: (K,) which objects count.
            max_travel: that what falls may travel in a step (in meters).
            draws: (m,) which draw of θ each particle has.
        """
        model, simulators = self._Model(chosen), self._pool.Simulators(chosen)
        states = make_states(
            model, poses=poses, velocities=velocities, links=links
        )
        fall_limit = MakeFallLimit(model, active, max_travel)
        for m, draw in enumerate(draws):
            try:
                states[m] = simulate(
                    model,
                    simulators.Get(draw),
                    state=states[m],
                    links=links,
                    time_step=time_steps[m],
                    fall_limit=fall_limit,
                )
            # The solver gave up on this particle; Drake's own assertions are
            # of the second type. What it left behind must not be used again.
            except (RuntimeError, SystemExit):
                simulators.Discard(draw)
                states[m] = np.nan
        return split_states(model, states)

    def PushOut(
        self,
        chosen: Links,
        *,
        link_poses: np.ndarray,
        poses: np.ndarray,
        supports: np.ndarray,
    ) -> np.ndarray:
        """Returns m particles without penetrations, (m, K, 7).

        Args:
            chosen: the robot's links that count.
            link_poses: (L, 7) of these links.
            poses: (m, K, 7) of the objects.
            supports: (m, K, 3) normals of what they stand on, or zeros.
        """
        model = self._Model(chosen)
        if chosen not in self._resolvers:
            self._resolvers[chosen] = PenetrationResolver(model, self._contacts)
        q = np.zeros((len(poses), model.diagram.plant().num_positions()))
        q[:, model.link_q] = link_poses
        q[:, model.object_q] = poses
        return self._resolvers[chosen].PushOut(q, supports)[:, model.object_q]

    def _Model(self, links: Links) -> ContactModel:
        if links not in self._contact_models:
            self._contact_models[links] = MakeContactModel(self._model, links)
        return self._contact_models[links]

    def _MakeSimulator(self, links: Links, draw: int) -> Simulator:
        model = self._Model(links)
        context = model.diagram.CreateDefaultContext()
        for k in range(len(model.objects)):
            SetPhysicalParameters(
                model=model,
                context=context,
                k=k,
                friction=self._parameters.friction[draw, k],
                mass=self._parameters.mass[draw, k],
                dissipation=self._parameters.dissipation[draw, k],
            )
        return MakeParticleSimulator(model, context)
