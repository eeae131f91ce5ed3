"""Unit quaternions as arrays (..., 4) in the order w, x, y, z.

All functions broadcast over the leading dimensions. q and -q are the same
rotation: functions that return an angle give the same for both.
"""

import numpy as np


def multiply(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Returns the Hamilton product p q, (..., 4): first q, then p."""
    w1, x1, y1, z1 = _split(p)
    w2, x2, y2, z2 = _split(q)
    return _join(
        w1 * w2 - x1 * x2 - y1 * y2 - z1 * z2,
        w1 * x2 + x1 * w2 + y1 * z2 - z1 * y2,
        w1 * y2 - x1 * z2 + y1 * w2 + z1 * x2,
        w1 * z2 + x1 * y2 - y1 * x2 + z1 * w2,
    )


def conjugate(q: np.ndarray) -> np.ndarray:
    """Returns the inverse rotation of unit quaternions, (..., 4)."""
    return np.asarray(q) * np.array([1.0, -1.0, -1.0, -1.0])


def normalize(q: np.ndarray) -> np.ndarray:
    """Returns q scaled to unit length, (..., 4)."""
    q = np.asarray(q)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def from_rotation_vector(r: np.ndarray) -> np.ndarray:
    """Returns exp(r), (..., 4): a turn by |r| radians about r, (..., 3)."""
    r = np.asarray(r)
    half = 0.5 * np.linalg.norm(r, axis=-1, keepdims=True)
    # sin(half) / (2 half), with its limit of 1/2 at 0: np.sinc has pi in it.
    return np.concatenate(
        [np.cos(half), 0.5 * np.sinc(half / np.pi) * r], axis=-1
    )


def to_rotation_vector(q: np.ndarray) -> np.ndarray:
    """Returns log(q), (..., 3): the rotation as a turn by at most pi."""
    q = np.asarray(q)
    q = np.where(q[..., :1] < 0, -q, q)
    length = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(length, q[..., :1])
    small = length < 1e-12
    return q[..., 1:] * np.where(small, 2.0, angle / np.where(small, 1, length))


def angle_between(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Returns the angle of the rotation p⁻¹ q, (...), in [0, pi]."""
    d = multiply(conjugate(p), q)
    return 2 * np.arctan2(
        np.linalg.norm(d[..., 1:], axis=-1), np.abs(d[..., 0])
    )


def rotate(q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Returns the vectors v, (..., 3), turned by q, (..., 4)."""
    w, x, y, z = _split(q)
    vx, vy, vz = _split(v)
    tx, ty, tz = (
        2 * (y * vz - z * vy),
        2 * (z * vx - x * vz),
        2 * (x * vy - y * vx),
    )
    return _join(
        vx + w * tx + y * tz - z * ty,
        vy + w * ty + z * tx - x * tz,
        vz + w * tz + x * ty - y * tx,
    )


def to_matrix(q: np.ndarray) -> np.ndarray:
    """Returns the rotation matrices of unit quaternions, (..., 3, 3)."""
    w, x, y, z = _split(q)
    R = np.empty((*np.shape(w), 3, 3))
    R[..., 0, 0] = 1 - 2 * (y * y + z * z)
    R[..., 0, 1] = 2 * (x * y - w * z)
    R[..., 0, 2] = 2 * (x * z + w * y)
    R[..., 1, 0] = 2 * (x * y + w * z)
    R[..., 1, 1] = 1 - 2 * (x * x + z * z)
    R[..., 1, 2] = 2 * (y * z - w * x)
    R[..., 2, 0] = 2 * (x * z - w * y)
    R[..., 2, 1] = 2 * (y * z + w * x)
    R[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return R


def from_matrix(R: np.ndarray) -> np.ndarray:
    """Returns the unit quaternions of rotation matrices (..., 3, 3), (..., 4).

    The entries of 4 q qᵀ are sums of those of R. Each of its columns is a
    multiple of q; the longest is taken.
    """
    R = np.asarray(R)
    xx, yy, zz = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    wx, wy, wz = (
        R[..., 2, 1] - R[..., 1, 2],
        R[..., 0, 2] - R[..., 2, 0],
        R[..., 1, 0] - R[..., 0, 1],
    )
    xy, xz, yz = (
        R[..., 1, 0] + R[..., 0, 1],
        R[..., 0, 2] + R[..., 2, 0],
        R[..., 2, 1] + R[..., 1, 2],
    )
    columns = [
        [1 + xx + yy + zz, wx, wy, wz],
        [wx, 1 + xx - yy - zz, xy, xz],
        [wy, xy, 1 - xx + yy - zz, yz],
        [wz, xz, yz, 1 - xx - yy + zz],
    ]
    outer = np.stack([np.stack(column, axis=-1) for column in columns], axis=-2)
    longest = np.argmax(np.diagonal(outer, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(outer, longest[..., None, None], axis=-2)[..., 0, :]
    return normalize(np.where(q[..., :1] < 0, -q, q))


# These two are here because np.moveaxis and np.stack take several times as long
# for a single quaternion.
def _split(x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Returns the components of x (..., n), n arrays (...)."""
    x = np.asarray(x)
    return tuple(x[..., i] for i in range(x.shape[-1]))


def _join(*components: np.ndarray) -> np.ndarray:
    """Returns (..., n), of n arrays (...) of the same shape."""
    x = np.empty((*np.shape(components[0]), len(components)))
    for i, component in enumerate(components):
        x[..., i] = component
    return x
