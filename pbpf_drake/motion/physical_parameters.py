"""θ: friction, mass and dissipation of the objects (Section 4.1)."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    ProximityProperties,
    RoleAssign,
)
from pydrake.multibody.plant import CoulombFriction
from pydrake.systems.framework import Context

from pbpf_drake.config.distributions import TruncatedGaussian
from pbpf_drake.config.physical_parameters_config import (
    PhysicalParametersConfig,
)
from pbpf_drake.motion.particle_plant import ParticlePlant
from pbpf_drake.shapes.contact_points import POINT_STIFFNESS, SHAPE_STIFFNESS


@dataclass(frozen=True)
class PhysicalParameters:
    """Draws of θ, in arrays of the same shape.

    Attributes:
        friction: (...) Coulomb coefficient of the object's contacts.
        mass: (...) in kilograms.
        dissipation: (...) Hunt-Crossley dissipation (in s/m).
    """

    friction: np.ndarray
    mass: np.ndarray
    dissipation: np.ndarray


def _draw(
    gaussian: TruncatedGaussian,
    shape: tuple[int, ...],
    rng: np.random.Generator,
) -> np.ndarray:
    draws = gaussian.mean + gaussian.stddev * rng.standard_normal(shape)
    return np.maximum(draws, gaussian.min)


def SamplePhysicalParameters(
    config: PhysicalParametersConfig,
    shape: tuple[int, ...],
    rng: np.random.Generator,
) -> PhysicalParameters:
    """Draws θ ~ N(μ_θ, σ_θ²), raised to the minima, in the given shape."""
    return PhysicalParameters(
        friction=_draw(config.friction, shape, rng),
        mass=_draw(config.mass, shape, rng),
        dissipation=_draw(config.dissipation, shape, rng),
    )


def SetPhysicalParameters(
    *,
    particle_plant: ParticlePlant,
    context: Context,
    k: int,
    friction: float,
    mass: float,
    dissipation: float,
) -> None:
    """Writes one object's θ into a context of a particle plant.

    Drake combines the coefficients of two surfaces as 2μ₁μ₂/(μ₁+μ₂). In the
    plant everything but the tracked objects has an unlimited coefficient, so
    half of ``friction`` on the object is ``friction`` at the contact.

    The stiffness of the contacts is in proportion to the mass, so that a light
    object sinks as deep as a heavy one, and is as easy to simulate.

    Args:
        particle_plant: what particles are simulated in.
        context: a root context of its diagram, changed.
        k: which of its objects.
        friction: coefficient of its contacts.
        mass: in kilograms; the rotational inertia scales with it.
        dissipation: Hunt-Crossley dissipation (in s/m).
    """
    diagram = particle_plant.diagram
    plant, scene_graph = diagram.plant(), diagram.scene_graph()
    body = plant.get_body(particle_plant.objects[k])
    body.SetMass(plant.GetMyMutableContextFromRoot(context), float(mass))
    for geometry, owner in particle_plant.owners.items():
        if owner != k:
            continue
        soft = geometry in particle_plant.points
        properties = ProximityProperties()
        AddContactMaterial(
            dissipation=float(dissipation),
            point_stiffness=float(mass)
            * (POINT_STIFFNESS if soft else SHAPE_STIFFNESS),
            friction=CoulombFriction(friction / 2, friction / 2),
            properties=properties,
        )
        scene_graph.AssignRole(
            scene_graph.GetMyMutableContextFromRoot(context),
            plant.get_source_id(),
            geometry,
            properties,
            RoleAssign.kReplace,
        )
