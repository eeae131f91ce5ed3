import numpy as np
from scipy.spatial.transform import Rotation

from pbpf_drake.poses import quaternions


def random_quaternions(n, seed=0):
    q = np.random.default_rng(seed).standard_normal((n, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def scipy_rotation(q):
    return Rotation.from_quat(q, scalar_first=True)


def same_rotation(p, q):
    return np.minimum(np.abs(p - q).max(axis=-1), np.abs(p + q).max(axis=-1))


def test_product_agrees_with_scipy():
    p, q = random_quaternions(50, 1), random_quaternions(50, 2)
    expected = (scipy_rotation(p) * scipy_rotation(q)).as_quat(
        scalar_first=True
    )
    assert same_rotation(quaternions.multiply(p, q), expected).max() < 1e-14


def test_conjugate_is_the_inverse():
    q = random_quaternions(10)
    identity = quaternions.multiply(q, quaternions.conjugate(q))
    np.testing.assert_allclose(
        identity, np.tile([1, 0, 0, 0], (10, 1)), atol=1e-15
    )


def test_rotation_vectors_agree_with_scipy_from_tiny_to_half_a_turn():
    axes = np.random.default_rng(3).standard_normal((6, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    angles = np.array([0, 1e-14, 1e-8, 1e-3, 1.0, np.pi - 1e-6])
    vectors = axes * angles[:, None]
    q = quaternions.from_rotation_vector(vectors)
    expected = Rotation.from_rotvec(vectors).as_quat(scalar_first=True)
    assert same_rotation(q, expected).max() < 1e-15
    for sign in (1, -1):
        back = quaternions.to_rotation_vector(sign * q)
        np.testing.assert_allclose(back, vectors, atol=1e-9)


def test_angle_between_is_scipys_magnitude_and_ignores_signs():
    p, q = random_quaternions(50, 4), random_quaternions(50, 5)
    expected = (scipy_rotation(p).inv() * scipy_rotation(q)).magnitude()
    np.testing.assert_allclose(quaternions.angle_between(p, q), expected)
    np.testing.assert_allclose(quaternions.angle_between(-p, q), expected)


def test_rotate_agrees_with_scipy():
    q = random_quaternions(20)
    v = np.random.default_rng(6).standard_normal((20, 3))
    np.testing.assert_allclose(
        quaternions.rotate(q, v), scipy_rotation(q).apply(v), atol=1e-14
    )


def test_normalize_gives_unit_length():
    q = quaternions.normalize(3 * random_quaternions(5))
    np.testing.assert_allclose(np.linalg.norm(q, axis=-1), 1)


def test_matrices_are_those_of_scipy():
    q = quaternions.normalize(np.random.default_rng(5).normal(size=(4, 3, 4)))
    matrices = quaternions.to_matrix(q)
    assert matrices.shape == (4, 3, 3, 3)
    expected = Rotation.from_quat(q.reshape(-1, 4)[:, [1, 2, 3, 0]])
    np.testing.assert_allclose(
        matrices.reshape(-1, 3, 3), expected.as_matrix(), atol=1e-14
    )
