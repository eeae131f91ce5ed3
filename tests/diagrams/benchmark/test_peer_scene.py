import numpy as np
from pydrake.geometry import Ellipsoid
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
import pytest
from recording_fixtures import SCENES

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams.benchmark.peer_scene import (
    ReadPeerScene,
    describe_shape,
)
from pbpf_drake.scene.scene_models import AddSceneModels


@pytest.fixture(scope="module")
def scene():
    return LoadScene(SCENES / "cheezit_gelatin_soup.yaml")


@pytest.fixture(scope="module")
def peer_scene(scene):
    return ReadPeerScene(scene)


def test_objects_have_the_shapes_and_inertias_of_their_files(peer_scene):
    cracker, gelatin, soup = peer_scene.objects
    (box,), (can,) = cracker.shapes, soup.shapes
    assert [o.name for o in peer_scene.objects] == [
        "cracker",
        "gelatin",
        "soup",
    ]
    assert (box.kind, box.size) == ("box", (0.16, 0.21344, 0.061))
    assert (can.kind, can.size) == ("cylinder", (0.03383, 0.1))
    # The can's axis is its local y.
    axis = can.X_BG.rotation() @ [0.0, 0.0, 1.0]
    np.testing.assert_allclose(np.abs(axis), [0, 1, 0], atol=1e-12)
    assert gelatin.mass == 0.097
    np.testing.assert_allclose(
        np.diag(gelatin.inertia), [5.01983e-05, 6.48317e-05, 0.000102446]
    )


def test_the_tables_top_is_at_height_zero(peer_scene):
    (table,) = peer_scene.fixed
    assert table.kind == "box"
    top = table.X_BG.translation()[2] + table.size[2] / 2
    assert abs(top) < 1e-12


def _moved(link, q: float) -> RigidTransform:
    """How a link is moved by its joint, in the link."""
    if not link.joint:
        return RigidTransform()
    if link.slides:
        return RigidTransform(q * link.axis)
    x, y, z = link.axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    R = np.eye(3) + np.sin(q) * cross + (1 - np.cos(q)) * cross @ cross
    turn = RigidTransform(RotationMatrix(R))
    at_joint = RigidTransform(link.p_BJ)
    return at_joint @ turn @ at_joint.inverse()


def test_links_are_where_drake_has_them_whatever_the_joints(scene, peer_scene):
    plant = MultibodyPlant(0.0)
    robot = AddSceneModels(plant, scene).robot
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q = np.random.default_rng(5).uniform(-0.5, 0.5, plant.num_positions(robot))
    plant.SetPositions(context, robot, q)
    names = plant.GetPositionNames(robot, add_model_instance_prefix=False)
    links = {link.name: link for link in peer_scene.links}

    def pose(name: str) -> RigidTransform:
        if not name:
            return RigidTransform()
        link = links[name]
        position = 0.0
        if link.joint:
            (i,) = [
                i for i, n in enumerate(names) if n.startswith(f"{link.joint}_")
            ]
            position = q[i]
        return pose(link.parent) @ link.X_PB @ _moved(link, position)

    assert len(links) == len(plant.GetBodyIndices(robot))
    for name in links:
        frame = plant.GetFrameByName(name, robot)
        X_WB = frame.CalcPoseInWorld(context)
        assert pose(name).IsNearlyEqualTo(X_WB, 1e-9), name


def test_a_shape_that_others_lack_is_refused_by_name():
    with pytest.raises(ValueError, match="'egg' is a Ellipsoid"):
        describe_shape(Ellipsoid(1.0, 2.0, 3.0), "egg")
