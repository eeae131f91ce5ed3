import numpy as np
from physics_fixtures import HEIGHTS, Simulation, make_model, wall_at
import pytest

from pbpf_drake.motion.fixed_contacts import FixedContacts
from pbpf_drake.poses import quaternions


@pytest.fixture(scope="module")
def model():
    return make_model("block", "soup", fixed=wall_at(0.3))


def _poses(num: int) -> np.ndarray:
    """Blocks and cans at the table and at the wall, in all directions."""
    rng = np.random.default_rng(0)
    poses = np.zeros((num, 2, 7))
    poses[..., :4] = quaternions.normalize(rng.standard_normal((num, 2, 4)))
    poses[: num // 2, :, :4] = [1.0, 0.0, 0.0, 0.0]
    poses[..., 4] = rng.uniform(0.2, 0.3, (num, 2))
    poses[..., 5] = [-0.3, 0.3]
    poses[:, 0, 6] = HEIGHTS["block"]
    poses[:, 1, 6] = HEIGHTS["soup"]
    poses[..., 6] += rng.uniform(-2e-3, 2e-3, (num, 2))
    return poses


def _from_drake(simulation, poses):
    """Contacts of the prediction's points with fixed geometry, sorted."""
    for k in range(2):
        simulation.set_pose(poses[k, :4], poses[k, 4:], k)
    contact = simulation.contact
    scene_graph = contact.diagram.scene_graph()
    inspector = scene_graph.model_inspector()
    query = scene_graph.get_query_output_port().Eval(
        scene_graph.GetMyContextFromRoot(simulation.context)
    )
    found = []
    for pair in query.ComputePointPairPenetration():
        sign = 1.0 if pair.id_A in contact.owners else -1.0
        own, other = (
            (pair.id_A, pair.id_B) if sign > 0 else (pair.id_B, pair.id_A)
        )
        shapes = [type(inspector.GetShape(i)).__name__ for i in (own, other)]
        if other in contact.fixed_geometries and "Sphere" in shapes:
            normal = sign * pair.nhat_BA_W
            found.append((contact.owners[own], pair.depth, *normal))
    return np.array(sorted(found)).reshape(-1, 5)


def test_contacts_are_those_of_the_prediction(model):
    simulation = Simulation(model)
    poses = _poses(60)
    contacts = FixedContacts(model).Find(poses)
    total = 0
    for m in range(len(poses)):
        mine = contacts.particles == m
        found = np.column_stack(
            [
                contacts.objects[mine],
                contacts.depths[mine],
                contacts.normals[mine],
            ]
        )
        expected = _from_drake(simulation, poses[m])
        assert len(found) == len(expected)
        found = np.array(sorted(map(tuple, found))).reshape(-1, 5)
        np.testing.assert_allclose(found[:, :2], expected[:, :2], atol=1e-9)
        # Equal depths come in any order.
        np.testing.assert_allclose(
            found[:, 2:].sum(axis=0), expected[:, 2:].sum(axis=0), atol=1e-6
        )
        total += len(found)
    assert total > 100


def test_points_of_a_fixed_box_touch_what_lies_on_it():
    """A block over its corner touches that, and has one corner on it."""
    model = make_model("block", fixed=wall_at(0.0))
    contacts = FixedContacts(model)
    corner = np.array([0.0, 0.2185 / 2, 0.1681])
    pose = np.array([1, 0, 0, 0, *corner + [0.0, 0.0, HEIGHTS["block"]]])
    found = contacts.Find(pose[None, None])
    np.testing.assert_allclose(found.normals, np.tile([0, 0, 1.0], (2, 1)))
    expected = [corner, corner + [0.045, -0.045, 0.0]]
    order = np.argsort(found.points[:, 0])
    np.testing.assert_allclose(found.points[order], expected, atol=1e-9)
    pose[6] += 2e-3
    assert len(contacts.Find(pose[None, None]).depths) == 0


@pytest.mark.filterwarnings("error")
def test_what_is_nowhere_touches_nothing(model):
    poses = np.full((3, 2, 7), np.nan)
    found = FixedContacts(model).Find(poses)
    assert found.points.shape == (0, 3) and found.particles.shape == (0,)
