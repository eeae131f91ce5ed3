"""What a process simulates particles with.

It takes long to build a plant, and longer to write θ into a context than to
simulate the particle. So both are kept, for each set of links that is near.
"""

from pydrake.systems.analysis import Simulator

from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.motion.particle_plant import MakeParticlePlant, ParticlePlant
from pbpf_drake.motion.particle_simulation import MakeParticleSimulator
from pbpf_drake.motion.penetration import PenetrationResolver
from pbpf_drake.motion.physical_parameters import (
    PhysicalParameters,
    SetPhysicalParameters,
)
from pbpf_drake.motion.robot_links import LinkSet
from pbpf_drake.motion.simulator_pool import SimulatorPool, Simulators
from pbpf_drake.scene.prediction_model import PredictionModel


class ParticlePhysics:
    """Plants, simulators and penetration resolvers, made when first used.

    Args:
        model: the scene's models.
        parameters: the draws of θ, arrays (M, K).
        contacts: finds the contacts with fixed models, of the same scene.
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
        self._plants: dict[LinkSet, ParticlePlant] = {}
        self._resolvers: dict[LinkSet, PenetrationResolver] = {}
        self._pool = SimulatorPool(self._MakeSimulator)

    def Plant(self, link_set: LinkSet) -> ParticlePlant:
        """Returns the plant with these links."""
        if link_set not in self._plants:
            self._plants[link_set] = MakeParticlePlant(self._model, link_set)
        return self._plants[link_set]

    def Simulators(self, link_set: LinkSet) -> Simulators:
        """Returns the simulators of the plant with these links, by draws of θ.

        Their contexts have θ. All else in them is from what they did last.
        """
        return self._pool.Simulators(link_set)

    def Resolver(self, link_set: LinkSet) -> PenetrationResolver:
        """Returns what pushes objects out, in the plant with these links."""
        if link_set not in self._resolvers:
            self._resolvers[link_set] = PenetrationResolver(
                self.Plant(link_set), self._contacts
            )
        return self._resolvers[link_set]

    def _MakeSimulator(self, link_set: LinkSet, draw: int) -> Simulator:
        particle_plant = self.Plant(link_set)
        context = particle_plant.diagram.CreateDefaultContext()
        for k in range(len(particle_plant.objects)):
            SetPhysicalParameters(
                particle_plant=particle_plant,
                context=context,
                k=k,
                friction=self._parameters.friction[draw, k],
                mass=self._parameters.mass[draw, k],
                dissipation=self._parameters.dissipation[draw, k],
            )
        return MakeParticleSimulator(particle_plant, context)
