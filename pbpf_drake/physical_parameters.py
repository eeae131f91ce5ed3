"""θ: friction, mass and dissipation of the objects (Section 4.1)."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import ProximityProperties, RoleAssign, SceneGraph
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context

from pbpf_drake.particle_filter_config import (
    PhysicalParametersConfig,
    TruncatedGaussian,
)


@dataclass(frozen=True)
class PhysicalParameters:
    """Draws of θ.

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
    plant: MultibodyPlant,
    plant_context: Context,
    scene_graph: SceneGraph,
    scene_graph_context: Context,
    body: BodyIndex,
    friction: float,
    mass: float,
    dissipation: float,
) -> None:
    """Writes one object's θ into the contexts of a prediction model.

    Drake combines the coefficients of two surfaces as 2μ₁μ₂/(μ₁+μ₂). In the
    prediction model everything but the tracked objects has an unlimited
    coefficient, so half of ``friction`` on the object is ``friction`` at the
    contact.

    Args:
        plant: the prediction model's plant.
        plant_context: its context, changed.
        scene_graph: the prediction model's scene graph.
        scene_graph_context: its context, changed.
        body: the object.
        friction: coefficient of its contacts.
        mass: in kilograms; the rotational inertia scales with it.
        dissipation: Hunt-Crossley dissipation (in s/m).
    """
    plant.get_body(body).SetMass(plant_context, mass)
    inspector = scene_graph.model_inspector()
    source = plant.get_source_id()
    for geometry in plant.GetCollisionGeometriesForBody(plant.get_body(body)):
        properties = ProximityProperties(
            inspector.GetProximityProperties(geometry)
        )
        properties.UpdateProperty(
            "material",
            "coulomb_friction",
            CoulombFriction(friction / 2, friction / 2),
        )
        properties.UpdateProperty(
            "material", "hunt_crossley_dissipation", float(dissipation)
        )
        scene_graph.AssignRole(
            scene_graph_context,
            source,
            geometry,
            properties,
            RoleAssign.kReplace,
        )
