import numpy as np
from physics_fixtures import (
    CAN_UPRIGHT,
    FLAT,
    GRAVITY,
    HEIGHTS,
    PROBE_RADIUS,
    Simulation,
    make_model,
    make_scene,
)
import pytest
from recording_fixtures import SCENES
from scipy.integrate import solve_ivp

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.motion.particle_plant import MakeParticlePlant
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.shapes.contact_points import POINT_STIFFNESS, REST_DEPTH

CROSSBEAM = """
- add_model:
    name: beam
    file: package://pbpf_drake/obstacles/scene_1_obstacle.sdf
- add_weld:
    parent: world
    child: beam::scene_1_obstacle
    X_PC:
      translation: [0.0, 0.0, 0.12525]
      rotation: !Rpy {deg: [90.0, 0.0, 0.0]}
"""
# A user's model: a box of 0.1 x 0.06 x 0.04 m, as a mesh.
CORNERS = np.array(
    [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
) * [0.05, 0.03, 0.02]
MESH_SDF = """<sdf version="1.7" xmlns:drake="http://drake.mit.edu">
<model name="brick"><link name="brick"><inertial><mass>0.5</mass><inertia>
<ixx>2e-4</ixx><iyy>5e-4</iyy><izz>6e-4</izz>
<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz>
</inertia></inertial><collision name="hull"><geometry><mesh><uri>brick.obj</uri>
{convex}</mesh></geometry></collision></link></model></sdf>"""


@pytest.mark.parametrize("mass", [0.1, 0.4, 1.5])
def test_four_points_carry_a_box_however_heavy_it_is(models, mass):
    simulation = Simulation(models("cracker"), mass=mass)
    z = HEIGHTS["cracker"]
    simulation.settle(FLAT, [0.0, 0.0, z], duration=0.6)
    assert simulation.pose()[6] == pytest.approx(z, abs=2e-5)


@pytest.mark.parametrize("dissipation", [20.0, 50.0, 100.0])
def test_the_dissipation_of_a_contact_is_the_objects_own(models, dissipation):
    """What is deep rises as Hunt and Crossley's equation says."""
    simulation = Simulation(
        models("cracker"), time_step=1e-4, dissipation=dissipation
    )
    depth, duration = 5e-4, 5e-3
    simulation.set_pose(FLAT, [0.0, 0.0, HEIGHTS["cracker"] - depth])
    simulation.set_velocity(np.zeros(6))
    simulation.advance(duration)

    def motion(_: float, state: np.ndarray) -> list[float]:
        x, v = state
        force = 4 * POINT_STIFFNESS * x * (1 + dissipation * v)
        return [v, GRAVITY - force]

    start = [REST_DEPTH + depth, 0.0]
    x, v = solve_ivp(motion, (0, duration), start, rtol=1e-8).y[:, -1]
    rise = simulation.pose()[6] - HEIGHTS["cracker"] + depth
    assert rise == pytest.approx(start[0] - x, rel=0.05)
    assert simulation.velocity()[5] == pytest.approx(-v, rel=0.05)


@pytest.mark.parametrize("friction", [0.1, 0.3, 0.6])
def test_the_friction_of_a_contact_with_the_robot_is_the_objects_own(
    models, friction
):
    """In the air, a probe hits a block and slips along it."""
    simulation = Simulation(models("block"), time_step=2e-4, friction=friction)
    simulation.set_pose(FLAT, [0.0, 0.0, 0.03])
    simulation.set_velocity(np.zeros(6))
    start = np.array([-0.045 - PROBE_RADIUS + 1e-6, -0.002])
    simulation.set_robot(start, [0.1, 1.0])
    simulation.advance(0.012)
    vx, vy = simulation.velocity()[3:5]
    assert vx > 0.03
    assert vy / vx == pytest.approx(friction, rel=0.02)


def _check_rest(simulation, k: int, pose, tolerance: float) -> None:
    """Fails unless an object stays at a pose for a second."""
    for _ in range(5):
        simulation.advance(0.2)
        now = simulation.pose(k)
        np.testing.assert_allclose(now[4:], pose[4:], atol=tolerance)
        angle = quaternions.angle_between(now[:4], pose[:4])
        assert angle < 20 * tolerance


def test_objects_rest_on_each_other(models):
    simulation = Simulation(models("cracker", "soup"))
    top = 2 * HEIGHTS["cracker"] + HEIGHTS["soup"]
    simulation.set_pose(CAN_UPRIGHT, [0.03, 0.04, top], 1)
    simulation.settle(FLAT, [0.0, 0.0, HEIGHTS["cracker"]])
    _check_rest(simulation, 0, [*FLAT, 0, 0, HEIGHTS["cracker"]], 1e-3)
    _check_rest(simulation, 1, [*CAN_UPRIGHT, 0.03, 0.04, top], 1e-3)


@pytest.mark.parametrize(
    "yaw",
    [
        np.pi / 2,
        0.8,
        pytest.param(
            0.0,
            marks=pytest.mark.xfail(
                strict=True, reason="no corner of either is on the other"
            ),
        ),
    ],
)
def test_a_box_rests_on_a_beam_that_is_narrower(yaw):
    simulation = Simulation(make_model("cracker", fixed=CROSSBEAM))
    q = quaternions.from_rotation_vector(np.array([0.0, 0.0, yaw]))
    pose = [*q, 0.0, 0.0, 0.2505 + HEIGHTS["cracker"]]
    simulation.settle(pose[:4], pose[4:], duration=0.5)
    _check_rest(simulation, 0, pose, 1e-3)


@pytest.mark.parametrize("speed", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("roll", [0.0, np.pi / 8])
def test_a_can_on_its_side_is_carried_by_its_rims(models, speed, roll):
    """They are octagons: 2.6 mm lower between two points than on one."""
    simulation = Simulation(models("soup"))
    q = quaternions.from_rotation_vector(np.array([0.0, roll, 0.0]))
    radius = 0.03383
    simulation.set_pose(q, [0.0, 0.0, radius])
    simulation.set_velocity([0.0, speed / radius, 0.0, speed, 0.0, 0.0])
    for _ in range(20):
        simulation.advance(0.05)
        height = simulation.pose()[6]
        low = radius * np.cos(np.pi / 8)
        assert low - 1.5e-3 < height < radius + 5e-4
    assert simulation.pose()[4] > -0.03


def _write_brick(folder, convex: str) -> None:
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    lines = [f"v {x} {y} {z}" for x, y, z in CORNERS]
    lines += [f"f {face}" for face in faces]
    (folder / "brick.obj").write_text("\n".join(lines))
    (folder / "brick.sdf").write_text(MESH_SDF.format(convex=convex))


@pytest.mark.parametrize("convex", ["", "<drake:declare_convex/>"])
def test_a_users_mesh_falls_flat_and_rests(tmp_path, convex):
    _write_brick(tmp_path, convex)
    files = {"brick": "package://scene/brick.sdf"}
    scene = make_scene(files, folder=str(tmp_path))
    simulation = Simulation(MakePredictionModel(scene), mass=0.5)
    tilted = quaternions.from_rotation_vector(np.array([0.2, 0.3, 0.0]))
    simulation.set_pose(tilted, [0.0, 0.0, 0.05])
    simulation.advance(1.5)
    start = simulation.pose()
    up = quaternions.rotate(start[:4], np.array([0.0, 0.0, 1.0]))
    np.testing.assert_allclose(up, [0.0, 0.0, 1.0], atol=1e-4)
    assert start[6] == pytest.approx(0.02, abs=1e-4)
    _check_rest(simulation, 0, start, 1e-4)


def test_geometries_have_one_owner(models):
    contact = Simulation(models("cracker", "soup")).contact
    owners = list(contact.owners.values())
    assert [owners.count(k) for k in (0, 1)] == [1 + 1 + 8, 1 + 1 + 16]
    assert len(contact.fixed_geometries) == 1 + 8
    assert not contact.fixed_geometries & contact.owners.keys()


def test_indices_are_those_of_the_plant(models):
    simulation = Simulation(models("cracker", "soup"))
    contact, plant = simulation.contact, simulation.plant
    rows = [*contact.link_q.ravel(), *contact.object_q.ravel()]
    assert sorted(rows) == list(range(plant.num_positions()))
    rows = [*contact.link_v.ravel(), *contact.object_v.ravel()]
    assert sorted(rows) == list(range(plant.num_velocities()))
    v = np.arange(plant.num_velocities(), dtype=float)
    plant.SetVelocities(simulation.plant_context, v)
    for k, index in enumerate(contact.objects):
        body = plant.get_body(index)
        velocity = body.EvalSpatialVelocityInWorld(simulation.plant_context)
        np.testing.assert_array_equal(
            v[contact.object_v[k]],
            [*velocity.rotational(), *velocity.translational()],
        )


def test_a_model_has_the_links_that_it_was_asked_for():
    model = MakePredictionModel(LoadScene(SCENES / "cheezit_1.yaml"))
    counts = []
    for links in (), (8, 9, 10), range(len(model.links)):
        contact = MakeParticlePlant(model, links)
        assert contact.link_set == tuple(links)
        assert contact.link_q.shape == (len(links), 7)
        counts.append(contact.diagram.plant().num_positions())
    assert counts == [7 + 7 * n for n in (0, 3, len(model.links))]


def test_the_robot_touches_nothing_but_objects():
    model = MakePredictionModel(LoadScene(SCENES / "cheezit_1.yaml"))
    simulation = Simulation(model)
    simulation.set_pose(FLAT, [5.0, 0.0, 1.0])
    scene_graph = simulation.contact.diagram.scene_graph()
    context = scene_graph.GetMyContextFromRoot(simulation.context)
    for q in np.random.default_rng(0).uniform(-2, 2, (20, 9)):
        simulation.set_robot(q, np.zeros(9))
        query = scene_graph.get_query_output_port().Eval(context)
        assert not query.ComputePointPairPenetration()


FILTERED = """
- add_collision_filter_group:
    name: through_the_table
    members: [block::block, table::table]
    ignored_collision_filter_groups: [through_the_table]
"""


@pytest.mark.parametrize(("fixed", "falls"), [("", False), (FILTERED, True)])
def test_what_the_scene_lets_pass_passes(fixed, falls):
    files = {"block": "package://pbpf_drake/planar_push/block.sdf"}
    scene = make_scene(files, last=fixed)
    simulation = Simulation(MakePredictionModel(scene))
    simulation.settle(FLAT, [0.0, 0.0, HEIGHTS["block"]])
    assert (simulation.pose()[6] < -0.1) == falls
