"""The models against published numbers and simple geometry."""

from model_world import MODELS, World, load_model
import numpy as np
from pydrake.geometry import Box, Cylinder, Role
import pytest

FILES = sorted(str(f.relative_to(MODELS)) for f in MODELS.glob("*/*.[su]*df"))
ARM = [f"panda_joint{i}" for i in range(1, 8)]
FINGERS = ["panda_finger_joint1", "panda_finger_joint2"]


@pytest.fixture(scope="module")
def panda() -> World:
    return load_model("panda/panda.urdf", weld="panda_link0")


def _set_random_arm(panda: World, rng) -> np.ndarray:
    q = panda.plant.GetPositionLowerLimits()
    q = rng.uniform(q, panda.plant.GetPositionUpperLimits())
    panda.plant.SetPositions(panda.context, q)
    return q


def _dh(a: float, alpha: float, d: float, theta: float) -> np.ndarray:
    """Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d), Craig's convention."""
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    return np.array(
        [
            [ct, -st, 0, a],
            [st * ca, ct * ca, -sa, -d * sa],
            [st * sa, ct * sa, ca, d * ca],
            [0, 0, 0, 1],
        ]
    )


def _dh_flange_and_hand(q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    right = np.pi / 2
    a = [0, 0, 0, 0.0825, -0.0825, 0, 0.088]
    alpha = [0, -right, right, right, -right, right, right]
    d = [0.333, 0, 0.316, 0, 0.384, 0, 0]
    X = np.eye(4)
    for i in range(7):
        X = X @ _dh(a[i], alpha[i], d[i], q[i])
    X_flange = X @ _dh(0, 0, 0.107, 0)
    return X_flange, X_flange @ _dh(0, 0, 0, -np.pi / 4)


def test_panda_flange_and_hand_follow_the_published_dh_parameters(panda):
    rng = np.random.default_rng(0)
    for _ in range(20):
        flange, hand = _dh_flange_and_hand(_set_random_arm(panda, rng))
        np.testing.assert_allclose(
            panda.frame_pose("panda_link8"), flange, atol=1e-9
        )
        np.testing.assert_allclose(
            panda.frame_pose("panda_hand"), hand, atol=1e-9
        )


def test_panda_fingers_slide_apart_along_the_hands_y_axis(panda):
    q = _set_random_arm(panda, np.random.default_rng(1))
    X_HW = np.linalg.inv(panda.frame_pose("panda_hand"))
    for side, y in ("left", q[7]), ("right", -q[8]):
        X_HF = X_HW @ panda.frame_pose(f"panda_{side}finger")
        np.testing.assert_allclose(X_HF[:3, 3], [0, y, 0.0584], atol=1e-12)
        np.testing.assert_allclose(X_HF[:3, :3], np.eye(3), atol=1e-12)


def test_panda_limits_are_the_published_ones(panda):
    lower = [-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]
    upper = [2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]
    speed, effort = [2.175] * 4 + [2.61] * 3, [87] * 4 + [12] * 3
    joints = [panda.joint(name) for name in ARM + FINGERS]
    assert [j.position_lower_limit() for j in joints] == lower + [0, 0]
    assert [j.position_upper_limit() for j in joints] == upper + [0.04, 0.04]
    assert [j.velocity_upper_limit() for j in joints] == speed + [0.2, 0.2]
    assert [j.velocity_lower_limit() for j in joints] == [
        -v for v in speed + [0.2, 0.2]
    ]
    motors = [panda.plant.GetJointActuatorByName(n) for n in ARM + FINGERS]
    assert [m.joint().name() for m in motors] == ARM + FINGERS
    assert [m.effort_limit() for m in motors] == effort + [100, 100]
    assert panda.plant.num_actuators() == 9


def test_panda_masses_are_the_identified_ones(panda):
    # Gaz et al., RA-L 2019, table of feasible dynamic parameters.
    masses = [0.629769, 4.970684, 0.646926, 3.228604, 3.587895, 1.225946]
    masses += [1.666555, 0.735522]
    for i, mass in enumerate(masses):
        body = panda.plant.GetBodyByName(f"panda_link{i}")
        assert body.default_mass() == mass


def test_panda_joints_and_centres_of_mass_lie_inside_its_shapes(panda):
    rng = np.random.default_rng(2)
    for _ in range(5):
        _set_random_arm(panda, rng)
        for name in ARM:
            joint = panda.joint(name)
            p_WJ = panda.frame_pose(joint.child_body().name())[:3, 3]
            depth = min(panda.distance(b, p_WJ) for b in panda.bodies())
            assert depth < -0.03, name
        for body in panda.bodies():
            if not panda.shape_ids(body):
                continue
            X_WB = body.EvalPoseInWorld(panda.context)
            p_BoBcm_B = body.CalcCenterOfMassInBodyFrame(panda.context)
            assert panda.distance(body, X_WB @ p_BoBcm_B) < 0, body.name()


def test_panda_hand_and_fingertips_have_the_published_size(panda):
    panda.plant.SetPositions(panda.context, np.zeros(9))
    X_WH = panda.frame_pose("panda_hand")

    def distance(body, p_H):
        p_W = X_WH[:3, :3] @ p_H + X_WH[:3, 3]
        return panda.distance(panda.plant.GetBodyByName(body), p_W)

    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    for sign in signs:
        corner = np.array([0, 0, 0.033]) + sign * [0.0315, 0.102, 0.033]
        assert distance("panda_hand", corner) == pytest.approx(0, abs=1e-9)
    for side, y in ("left", 0.005), ("right", -0.005):
        tip = np.array([0, y, 0.1124])
        body = f"panda_{side}finger"
        assert distance(body, tip) == pytest.approx(0, abs=1e-9)


def test_panda_does_not_collide_with_itself(panda):
    assert panda.plant.num_collision_geometries() > 20
    candidates = panda.scene_graph.model_inspector().GetCollisionCandidates()
    assert not candidates


@pytest.mark.parametrize("file", FILES)
def test_model_parses_without_warnings_and_its_inertias_are_physical(file):
    world = load_model(file)
    for body in world.bodies():
        inertia = body.default_spatial_inertia()
        if body.default_mass() == 0:  # A frame without matter.
            assert not world.shape_ids(body)
            continue
        moments = inertia.Shift(inertia.get_com()).CalcRotationalInertia()
        principal = moments.CalcPrincipalMomentsOfInertia()
        assert principal.min() > 0
        assert principal.max() < sum(principal) - principal.max()


@pytest.mark.parametrize(
    "file, shape, mass",
    [
        ("cracker/cracker.sdf", Box(0.16, 0.21344, 0.061), 0.411),
        ("gelatin/gelatin.sdf", Box(0.0851, 0.0737, 0.0279), 0.097),
        ("soup/soup.sdf", Cylinder(0.03383, 0.1), 0.349),
        ("planar_push/block.sdf", Box(0.09, 0.09, 0.013), 1.053),
        ("obstacles/scene_1_obstacle.sdf", Box(0.1968, 0.2505, 0.0725), None),
        ("obstacles/scene_4_support.sdf", Box(0.207, 0.2185, 0.1681), None),
    ],
)
def test_object_is_one_body_with_one_shape_around_its_origin(file, shape, mass):
    world = load_model(file)
    (body,) = world.bodies()
    (geometry,) = world.shape_ids(body)
    inspector = world.scene_graph.model_inspector()
    found = inspector.GetShape(geometry)
    X_BG = inspector.GetPoseInFrame(geometry)
    assert body.name() == file.split("/")[1].removesuffix(".sdf")
    assert mass is None or body.default_mass() == mass
    np.testing.assert_array_equal(X_BG.translation(), 0)
    if isinstance(shape, Box):
        np.testing.assert_array_equal(found.size(), shape.size())
        assert X_BG.IsExactlyIdentity()
    else:
        assert (found.radius(), found.length()) == (0.03383, 0.1)
        axis = X_BG.rotation().col(2)
        np.testing.assert_allclose(np.abs(axis), [0, 1, 0], atol=1e-12)


@pytest.mark.parametrize("file", FILES)
def test_every_model_can_be_seen(file):
    inspector = load_model(file).scene_graph.model_inspector()
    assert inspector.NumGeometriesWithRole(Role.kIllustration) > 0
    assert inspector.NumGeometriesWithRole(Role.kPerception) > 0
