"""Models that are nothing but a mesh file.

Drake's own parser takes only OBJ files, and only closed meshes, as it computes
their volume. Here the convex hull stands for the mesh where it collides, as
everywhere in this package, and also where its mass and inertia are computed. So
an open scan will do as well.
"""

from pathlib import Path

from pydrake.geometry import (
    Convex,
    GeometryInstance,
    IllustrationProperties,
    Mesh,
    PerceptionProperties,
    ProximityProperties,
    Rgba,
)
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import ModelDirective, PackageMap
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import CalcSpatialInertia, RigidBody

from pbpf_drake.scene.mesh_files import CONVERTED_ENDINGS, ReadableMesh

# How the names of mesh files end that can be models.
MESH_ENDINGS = (".obj", ".gltf", *CONVERTED_ENDINGS)
# The hull's density (in kg/m³): that of a carton with something in it. The
# filter doesn't use it, as it draws masses of its own.
_DENSITY = 500.0
_GREY = Rgba(0.7, 0.7, 0.7)


def IsMeshModel(directive: ModelDirective) -> bool:
    """Tells whether a directive adds a model whose file is a mesh."""
    model = directive.add_model
    return model is not None and model.file.lower().endswith(MESH_ENDINGS)


def AddMeshModel(
    plant: MultibodyPlant, directive: ModelDirective, packages: PackageMap
) -> None:
    """Adds a model that is a mesh: one body, which has the model's name.

    Args:
        plant: not finalized yet.
        directive: adds a mesh model, see IsMeshModel.
        packages: where package:// leads to.

    Raises:
        ValueError: the mesh has no convex hull, or the directive gives the pose
            of another body, or in another frame than the world.
        RuntimeError: there is no such package, or no such file in it.
    """
    model = directive.add_model
    url = packages.ResolveUrl(model.file)
    try:
        path = str(ReadableMesh(Path(url), hull=True))
        inertia = CalcSpatialInertia(shape=Convex(path), density=_DENSITY)
    except (RuntimeError, ValueError) as error:
        raise ValueError(
            f"add_model {model.name!r}: {url} has no convex hull: {error}"
        ) from error
    instance = plant.AddModelInstance(model.name)
    body = plant.AddRigidBody(model.name, instance, inertia)
    if plant.geometry_source_is_registered():
        seen = str(ReadableMesh(Path(url), hull=False))
        _add_geometry(plant, body, path, seen)
    for name, pose in model.default_free_body_pose.items():
        frame = pose.base_frame or "world"
        if name != model.name or frame != "world":
            raise ValueError(
                f"add_model {model.name!r}: default_free_body_pose is that of "
                f"{name!r} in {frame!r}; expected that of {model.name!r} in "
                "the world: a mesh is one body, of the model's name"
            )
        plant.SetDefaultFloatingBaseBodyPose(body, pose.GetDeterministicValue())


def _add_geometry(
    plant: MultibodyPlant, body: RigidBody, path: str, visual: str
) -> None:
    """Adds the mesh to look at, and its hull to collide with and to render.

    An OBJ file may lack normals, and then Drake doesn't render it. The hull
    always has them.
    """
    at = RigidTransform()
    plant.RegisterCollisionGeometry(
        body, at, Mesh(path), f"{body.name()}_collision", ProximityProperties()
    )
    seen = GeometryInstance(at, Mesh(visual), f"{body.name()}_mesh")
    seen.set_illustration_properties(IllustrationProperties())
    seen.mutable_illustration_properties().AddProperty(
        "phong", "diffuse", _GREY
    )
    rendered = GeometryInstance(at, Convex(path), f"{body.name()}_hull")
    rendered.set_perception_properties(PerceptionProperties())
    for geometry in seen, rendered:
        plant.RegisterVisualGeometry(body, geometry)
