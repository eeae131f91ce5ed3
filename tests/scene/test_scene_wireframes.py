from filter_fixtures import planar_scene
import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
import pytest

from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_wireframes import SceneWireframes


@pytest.fixture(scope="module")
def dut():
    return SceneWireframes(MakePredictionModel(planar_scene()))


def test_objects_are_where_they_are_told_to_be(dut):
    X_WO = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1.0, 2.0, 3.0])
    edges = dut.ObjectEdges(0, X_WO)
    own = dut.ObjectEdges(0, RigidTransform())
    expected = (X_WO @ own.reshape(-1, 3).T).T.reshape(edges.shape)
    np.testing.assert_allclose(edges, expected, atol=1e-12)
    # A block of 90 x 90 x 13 mm (planar_push/block.sdf).
    size = np.ptp(own.reshape(-1, 3), axis=0)
    np.testing.assert_allclose(size, [0.09, 0.09, 0.013], atol=1e-9)


def test_the_robot_follows_its_joints_and_the_table_stays(dut):
    first = dut.SurroundingEdges(np.array([0.1, 0.2]))
    second = dut.SurroundingEdges(np.array([0.4, 0.1]))
    moved = (second - first).reshape(-1, 3)
    follows = np.all(np.isclose(moved, [0.3, -0.1, 0.0]), axis=1)
    stays = np.all(moved == 0, axis=1)
    assert follows.any() and stays.any()
    assert np.all(follows | stays)
    # The probe is a cylinder along z around the two joints.
    probe = first.reshape(-1, 3)[follows]
    radii = np.hypot(*(probe[:, :2] - [0.1, 0.2]).T)
    np.testing.assert_allclose(radii, 0.004745, atol=1e-9)
