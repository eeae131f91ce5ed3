"""Loads a model or a scene into a plant, for the tests of both."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import Diagram, DiagramBuilder

from pbpf_drake.scene import CameraConfig, LoadScene
from pbpf_drake.scene_models import AddSceneModels, data_folder

MODELS = data_folder("models")


@dataclass
class World:
    """A plant with its scene graph and one context."""

    plant: MultibodyPlant
    scene_graph: SceneGraph
    diagram: Diagram

    def __post_init__(self):
        self.root = self.diagram.CreateDefaultContext()
        self.context = self.plant.GetMyContextFromRoot(self.root)

    def query(self):
        return self.scene_graph.get_query_output_port().Eval(
            self.scene_graph.GetMyContextFromRoot(self.root)
        )

    def shape_ids(self, body: RigidBody):
        return self.plant.GetCollisionGeometriesForBody(body)

    def distance(self, body: RigidBody, p_WQ: np.ndarray) -> float:
        """Signed distance of a point to the nearest of a body's shapes."""
        ids = self.shape_ids(body)
        found = self.query().ComputeSignedDistanceToPoint(p_WQ)
        return min((f.distance for f in found if f.id_G in ids), default=1e9)

    def bodies(self) -> list[RigidBody]:
        indices = range(1, self.plant.num_bodies())
        return [self.plant.get_body(BodyIndex(i)) for i in indices]

    def joint(self, name: str):
        return self.plant.GetJointByName(name)

    def frame_pose(self, name: str) -> np.ndarray:
        frame = self.plant.GetFrameByName(name)
        return frame.CalcPoseInWorld(self.context).GetAsMatrix4()


def _world(add_models) -> World:
    builder = DiagramBuilder()
    plant, scene_graph = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    add_models(plant)
    plant.Finalize()
    return World(plant, scene_graph, builder.Build())


def load_model(file: str, weld: str = "") -> World:
    """Parses one model strictly; ``weld`` names a frame to fix."""

    def add(plant):
        parser = Parser(plant)
        parser.SetStrictParsing()  # Warnings become errors.
        parser.AddModels(str(MODELS / file))
        if weld:
            base = plant.GetFrameByName(weld)
            plant.WeldFrames(plant.world_frame(), base)

    return _world(add)


def load_scene(name: str) -> tuple[World, CameraConfig, RigidBody]:
    """Loads a scene file; returns also its camera and tracked body."""
    path = data_folder("diagrams") / "scenes" / f"{name}.yaml"
    scene, found = LoadScene(path), []
    world = _world(lambda plant: found.append(AddSceneModels(plant, scene)))
    return world, scene.camera, world.plant.get_body(found[0].objects[0])
