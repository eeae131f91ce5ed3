import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia
import pytest

from pbpf_drake.motion.push_on_support import MassDistribution, push_on_support
from pbpf_drake.poses import quaternions

UP = np.array([0.0, 0.0, 1.0])
NOTHING = np.zeros(3)


def _body(p_OCm=(0.0, 0.0, 0.0), size=(0.2, 0.1, 0.06), mass=0.7):
    """A solid box whose centre is at p_OCm."""
    inertia = SpatialInertia(
        mass,
        np.array(p_OCm),
        UnitInertia.SolidBox(*size).ShiftFromCenterOfMass(np.array(p_OCm)),
    )
    return MultibodyPlant(0.0).AddRigidBody("box", inertia)


def _masses(body) -> MassDistribution:
    return MassDistribution.OfBodies([body]).of(0)


def _pose(rng: np.random.Generator) -> np.ndarray:
    q = quaternions.normalize(rng.standard_normal(4))
    return np.concatenate([q, rng.uniform(-0.5, 0.5, 3)])


def _unit(rng: np.random.Generator) -> np.ndarray:
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)


def _moved(X_WO: np.ndarray, X_WN: np.ndarray, p_WC: np.ndarray) -> np.ndarray:
    """How far a point C that is fixed to the object moves, from O to N."""
    turn = quaternions.multiply(X_WN[:4], quaternions.conjugate(X_WO[:4]))
    return X_WN[4:] + quaternions.rotate(turn, p_WC - X_WO[4:]) - p_WC


def _least_energy(X_WO, inertia, *, p_WC, normals, distances, supports):
    """Where the motion of least kinetic energy takes O, by a linear solve."""
    R = quaternions.to_matrix(X_WO[:4])
    about_com = inertia.Shift(inertia.get_com())
    G = R @ about_com.get_unit_inertia().CopyToFullMatrix3() @ R.T
    p_WCm = X_WO[4:] + R @ inertia.get_com()
    M = np.zeros((6, 6))
    M[:3, :3], M[3:, 3:] = G, np.eye(3)
    across = np.linalg.svd(supports[None])[2][1:]
    zeros = np.zeros(3)
    along = normals - (normals @ supports) * supports
    A = np.array(
        [
            [*np.cross(p_WC - p_WCm, along), *along],
            [*zeros, *supports],
            [*across[0], *zeros],
            [*across[1], *zeros],
        ]
    )
    kkt = np.block([[M, A.T], [A, np.zeros((4, 4))]])
    x = np.linalg.solve(kkt, [*np.zeros(6), distances, 0, 0, 0])[:6]
    turn = quaternions.from_rotation_vector(x[:3])
    q = quaternions.multiply(turn, X_WO[:4])
    p = p_WCm + x[3:] - quaternions.rotate(q, inertia.get_com())
    return q, p


@pytest.mark.parametrize("seed", range(20))
def test_it_is_the_motion_of_least_energy(seed):
    rng = np.random.default_rng(seed)
    body = _body(p_OCm=rng.uniform(-0.03, 0.03, 3))
    X_WO, support = _pose(rng), _unit(rng)
    normal = _unit(rng)
    while abs(normal @ support) > 0.6:
        normal = _unit(rng)
    push = {
        "p_WC": X_WO[4:] + rng.uniform(-0.1, 0.1, 3),
        "normals": normal,
        "distances": rng.uniform(0.0, 0.02),
        "supports": support,
    }
    found = push_on_support(X_WO, _masses(body), **push)
    q, p = _least_energy(X_WO, body.default_spatial_inertia(), **push)
    assert quaternions.angle_between(found[:4], q) < 1e-7
    np.testing.assert_allclose(found[4:], p, atol=1e-12)


def test_many_are_pushed_as_one_by_one():
    rng = np.random.default_rng(0)
    masses = MassDistribution.OfBodies(
        [_body(), _body(p_OCm=(0.02, 0.0, 0.01), size=(0.1, 0.3, 0.2))]
    )
    objects = np.array([0, 1, 1, 0, 1])
    X_WO = np.array([_pose(rng) for _ in objects])
    pushes = {
        "p_WC": X_WO[:, 4:] + rng.uniform(-0.1, 0.1, (5, 3)),
        "normals": np.array([_unit(rng) for _ in objects]),
        "distances": rng.uniform(0.0, 0.02, 5),
        "supports": np.array([UP, UP, NOTHING, _unit(rng), UP]),
    }
    together = push_on_support(X_WO, masses.of(objects), **pushes)
    for i, k in enumerate(objects):
        one = {name: values[i] for name, values in pushes.items()}
        alone = push_on_support(X_WO[i], masses.of(k), **one)
        np.testing.assert_allclose(together[i], alone, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("stands", [True, False])
@pytest.mark.parametrize("seed", range(5))
def test_the_point_moves_by_the_distance(stands, seed):
    rng = np.random.default_rng(seed)
    X_WO = _pose(rng)
    normal, p_WC = np.array([0.6, 0.8, 0.0]), X_WO[4:] + [0.03, -0.05, 0.02]
    after = push_on_support(
        X_WO,
        _masses(_body()),
        p_WC=p_WC,
        normals=normal,
        distances=1e-4,
        supports=stands * UP,
    )
    assert _moved(X_WO, after, p_WC) @ normal == pytest.approx(1e-4, rel=1e-3)


def test_a_push_through_the_centre_of_mass_does_not_turn():
    X_WO = np.array([1.0, 0, 0, 0, 0.1, 0.2, 0.3])
    p_OCm = np.array([0.02, 0.01, 0.0])
    after = push_on_support(
        X_WO,
        _masses(_body(p_OCm)),
        p_WC=X_WO[4:] + p_OCm - [0.1, 0.0, 0.0],
        normals=np.array([1.0, 0.0, 0.0]),
        distances=0.01,
        supports=UP,
    )
    np.testing.assert_allclose(
        after, X_WO + [0, 0, 0, 0, 0.01, 0, 0], atol=1e-15
    )


def test_the_angle_of_a_push_off_the_centre_is_that_of_a_rod():
    """A thin rod (k² = L²/12) hit at its end: ω = 6 v / L, v of its centre."""
    length = 0.3
    rod = _body(size=(length, 1e-6, 1e-6))
    X_WO = np.array([1.0, 0, 0, 0, 0, 0, 0])
    after = push_on_support(
        X_WO,
        _masses(rod),
        p_WC=np.array([length / 2, 0.0, 0.0]),
        normals=np.array([0.0, 1.0, 0.0]),
        distances=4e-3,
        supports=UP,
    )
    # The end moves by v + ω L/2 = 4 v.
    np.testing.assert_allclose(after[4:], [0.0, 1e-3, 0.0], atol=1e-12)
    angle = quaternions.to_rotation_vector(after[:4])
    np.testing.assert_allclose(angle, [0.0, 0.0, 6e-3 / length], rtol=1e-9)


@pytest.mark.parametrize("mass", [0.1, 5.0])
def test_the_mass_does_not_matter(mass):
    rng = np.random.default_rng(0)
    X_WO = _pose(rng)
    push = {
        "p_WC": X_WO[4:] + [0.03, 0.02, 0.01],
        "normals": np.array([1.0, 0.0, 0.0]),
        "distances": 0.01,
        "supports": UP,
    }
    found = [
        push_on_support(X_WO, _masses(_body(mass=m)), **push)
        for m in (1.0, mass)
    ]
    np.testing.assert_allclose(*found, rtol=1e-12)


@pytest.mark.parametrize(
    ("normal", "support"),
    [
        ([0.6, 0.0, 0.8], UP),  # Lifted off its support.
        ([0.0, 0.0, -1.0], UP),  # Pressed into it.
        ([1.0, 0.0, 0.0], NOTHING),
    ],
)
def test_what_cannot_slide_is_moved_along_the_normal(normal, support):
    rng = np.random.default_rng(1)
    X_WO = _pose(rng)
    after = push_on_support(
        X_WO,
        _masses(_body()),
        p_WC=X_WO[4:] + [0.03, 0.02, 0.01],
        normals=np.array(normal),
        distances=0.01,
        supports=support,
    )
    np.testing.assert_array_equal(after[:4], X_WO[:4])
    np.testing.assert_allclose(after[4:] - X_WO[4:], 0.01 * np.array(normal))


def test_what_stands_keeps_its_height_and_its_tilt():
    X_WO = np.array([1.0, 0, 0, 0, 0.1, 0.2, 0.3])
    after = push_on_support(
        X_WO,
        _masses(_body()),
        p_WC=X_WO[4:] + [-0.1, 0.04, 0.03],
        normals=np.array([0.8, 0.0, -0.6]),
        distances=0.01,
        supports=UP,
    )
    assert after[6] == X_WO[6]
    np.testing.assert_allclose(quaternions.rotate(after[:4], UP), UP)
    assert quaternions.angle_between(after[:4], X_WO[:4]) > 0.01
