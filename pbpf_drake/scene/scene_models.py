"""Parses the models of a scene into a MultibodyPlant and finds their roles."""

from dataclasses import dataclass, replace
from pathlib import Path

from pydrake.multibody.parsing import (
    ModelDirectives,
    PackageMap,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BodyIndex,
    JointIndex,
    ModelInstanceIndex,
    RigidBody,
)

from pbpf_drake.config.config_checks import one_line
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.scene.directive_checks import CheckDirectiveFiles
from pbpf_drake.scene.drake_log import EachMessageOnce
from pbpf_drake.scene.mesh_models import AddMeshModel, IsMeshModel
from pbpf_drake.scene.model_packages import AddAmentPackages, AddScenePackages
from pbpf_drake.scene.scene_directives import MakeReadable
from pbpf_drake.scene.scene_warnings import WarnOnce


@dataclass(frozen=True)
class SceneModels:
    """Which model instance of a plant plays which role.

    Attributes:
        robot: the robot's model instance.
        objects: the body of each tracked object, in the scene's order.
        fixed: the bodies of all other models, and the world body.
        warnings: one sentence for everything of the model files that is left
            out.
    """

    robot: ModelInstanceIndex
    objects: tuple[BodyIndex, ...]
    fixed: tuple[BodyIndex, ...]
    warnings: tuple[str, ...] = ()


def data_folder(name: str) -> Path:
    """Returns a folder of data that comes with the package.

    Args:
        name: "models" or "diagrams", be it installed or in a clone.

    Raises:
        FileNotFoundError: there is no such folder.
    """
    folder = (Path(__file__).parents[1] / name).resolve()
    if folder.is_dir():
        return folder
    raise FileNotFoundError(f"pbpf_drake is installed without its {name}")


def MakePackageMap(scene: Scene) -> PackageMap:
    """Returns where the scene's directives find packages.

    package://pbpf_drake leads to this project's models, package://scene to the
    folder of the scene file. The scene's ``packages`` come next, then those in
    ROS_PACKAGE_PATH, then the folders in share of AMENT_PREFIX_PATH. Where two
    are called the same, the first counts.

    Raises:
        ValueError: the scene's ``packages`` don't fit, see AddScenePackages.
    """
    packages = PackageMap()
    packages.Add("pbpf_drake", str(data_folder("models")))
    AddScenePackages(packages, scene)
    packages.PopulateFromRosPackagePath()
    AddAmentPackages(packages)
    return packages


def AddSceneModels(plant: MultibodyPlant, scene: Scene) -> SceneModels:
    """Adds the scene's models to a plant that is not finalized yet.

    What is left out is said in Python's log, once; what Drake warns of, once
    for each model file.

    Raises:
        ValueError: a model can't be parsed (a file is missing, say), the
            robot or a tracked model doesn't exist or can't play its role, or
            another model isn't welded to the world.
    """
    where = f"Scene {scene.path or '(without a file)'}"
    try:
        warnings = _parse_models(plant, scene)
        models = _find_roles(plant, scene)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error
    WarnOnce(warnings)
    return replace(models, warnings=tuple(warnings))


def _parse_models(plant: MultibodyPlant, scene: Scene) -> list[str]:
    """Parses all models into a plant; returns what was left out."""
    packages = MakePackageMap(scene)
    CheckDirectiveFiles(scene.directives, packages, Path(scene.path).parent)
    readable = MakeReadable(scene, packages)
    parser = Parser(plant)
    parser.package_map().AddMap(packages)
    meshes = [d for d in readable.directives if IsMeshModel(d)]
    others = [d for d in readable.directives if not IsMeshModel(d)]
    try:
        with EachMessageOnce():
            for directive in meshes:
                AddMeshModel(plant, directive, packages)
            ProcessModelDirectives(ModelDirectives(directives=others), parser)
    except (Exception, SystemExit) as error:
        # Drake ends the program where one of its assertions fails.
        message = readable.models.OriginalNames(one_line(error))
        raise ValueError(message) from error
    return readable.models.warnings


def _find_roles(plant: MultibodyPlant, scene: Scene) -> SceneModels:
    robot = _instance(plant, "robot", scene.robot)
    objects = tuple(_tracked_body(plant, name) for name in scene.tracked)
    tracked = {plant.GetModelInstanceByName(n) for n in scene.tracked}
    welded = set(b.index() for b in plant.GetBodiesWeldedTo(plant.world_body()))
    fixed = []
    for i in range(plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        if body.model_instance() in tracked | {robot}:
            continue
        if body.index() not in welded:
            raise ValueError(
                f"{body.scoped_name()} can move, but its model is neither "
                "the robot nor tracked; weld it to the world or track it"
            )
        fixed.append(body.index())
    return SceneModels(robot, objects, tuple(fixed))


def _instance(
    plant: MultibodyPlant, field: str, name: str
) -> ModelInstanceIndex:
    if not plant.HasModelInstanceNamed(name):
        known = [
            plant.GetModelInstanceName(ModelInstanceIndex(i))
            for i in range(2, plant.num_model_instances())
        ]
        raise ValueError(f"{field} names {name!r}; the models are {known}")
    return plant.GetModelInstanceByName(name)


def _tracked_body(plant: MultibodyPlant, name: str) -> BodyIndex:
    instance = _instance(plant, "tracked", name)
    bodies = plant.GetBodyIndices(instance)
    if len(bodies) != 1:
        raise ValueError(
            f"tracked model {name!r} has {len(bodies)} bodies; expected one"
        )
    body: RigidBody = plant.get_body(bodies[0])
    for index in range(plant.num_model_instances()):
        for j in plant.GetJointIndices(ModelInstanceIndex(index)):
            joint = plant.get_joint(JointIndex(j))
            _check_free(joint.child_body(), body, name)
            _check_free(joint.parent_body(), body, name)
    return body.index()


def _check_free(jointed: RigidBody, body: RigidBody, name: str) -> None:
    if jointed.index() == body.index():
        raise ValueError(
            f"tracked model {name!r} is attached by a joint or a weld; "
            "expected one free body that is no part of the robot"
        )
