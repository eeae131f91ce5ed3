"""How things touch in the truth: hydroelastic, with a friction of its own."""

from pydrake.geometry import (
    AddCompliantHydroelasticProperties,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    Capsule,
    CollisionFilterDeclaration,
    Cylinder,
    Ellipsoid,
    GeometrySet,
    ProximityProperties,
    RoleAssign,
    SceneGraph,
    Shape,
    Sphere,
)
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from pbpf_drake.config.recording_config import RecordingConfig
from pbpf_drake.scene.scene_models import SceneModels
from pbpf_drake.truth.truth_parameters import TruthParameters


def SetTrueContact(
    *,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    models: SceneModels,
    config: RecordingConfig,
    parameters: TruthParameters,
) -> None:
    """Replaces what the models' files say of contact by what is true.

    The tracked objects are compliant; the robot and what is fixed are rigid.

    Args:
        plant: not finalized yet, with the models.
        scene_graph: the plant's.
        models: the roles of the models.
        config: stiffness and dissipation.
        parameters: friction, drawn for this run.
    """
    inspector = scene_graph.model_inspector()
    for i in range(plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        is_robot = body.model_instance() == models.robot
        mu = parameters.robot_friction if is_robot else parameters.friction
        for geometry in plant.GetCollisionGeometriesForBody(body):
            properties = ProximityProperties()
            radius = _radius(inspector.GetShape(geometry))
            length = config.mesh_resolution * radius
            if body.index() in models.objects:
                AddCompliantHydroelasticProperties(
                    length, config.hydroelastic_modulus, properties
                )
            else:
                AddRigidHydroelasticProperties(length, properties)
            AddContactMaterial(
                dissipation=config.dissipation,
                friction=CoulombFriction(mu, mu),
                properties=properties,
            )
            scene_graph.AssignRole(
                plant.get_source_id(), geometry, properties, RoleAssign.kReplace
            )


def ExcludeSelfContact(
    *, plant: MultibodyPlant, scene_graph: SceneGraph, models: SceneModels
) -> None:
    """Keeps the robot's links from touching each other.

    The hulls of a real robot's links overlap: they would push it apart.

    Args:
        plant: not finalized yet, with the models.
        scene_graph: the plant's.
        models: the roles of the models.
    """
    links = GeometrySet(
        [
            plant.GetBodyFrameIdOrThrow(index)
            for index in plant.GetBodyIndices(models.robot)
        ]
    )
    filters = CollisionFilterDeclaration().ExcludeWithin(links)
    scene_graph.collision_filter_manager().Apply(filters)


def _radius(shape: Shape) -> float:
    """Returns the radius (in meters) of a round shape, 1 for any other.

    The contact meshes of the others don't depend on it.
    """
    if isinstance(shape, Sphere | Cylinder | Capsule):
        return shape.radius()
    if isinstance(shape, Ellipsoid):
        return min(shape.a(), shape.b(), shape.c())
    return 1.0
