"""Which objects stand on something fixed, and the normal of what carries them.

An object at rest on a table can slide and turn on it. Noise that lifts or tilts
it would only make it fall back, so noise leaves it on its support.
"""

import numpy as np

from pbpf_drake.motion.fixed_contacts import PointContacts

# A support is flat if the normals of its contacts differ by at most 3° from
# their mean. This is cos 3°.
_SAME_DIRECTION = 0.9986
# It also needs a contact at least this far from the line through two others (in
# meters).
_MIN_WIDTH = 2e-3


def find_supports(
    contacts: PointContacts, num_particles: int, num_objects: int
) -> np.ndarray:
    """Returns the flat support of every object of M particles, (M, K, 3).

    A support is given by its unit normal. It has at least three contacts, which
    agree in direction and are not on one line. Zeros stand for no support.

    Args:
        contacts: of the objects with fixed models.
        num_particles: M.
        num_objects: K.
    """
    supports = np.zeros((num_particles * num_objects, 3))
    owner = contacts.particles * num_objects + contacts.objects
    if len(owner):
        order = np.argsort(owner, kind="stable")
        owners, first = np.unique(owner[order], return_index=True)
        supports[owners] = support_normals(
            contacts.points[order], contacts.normals[order], first
        )
    return supports.reshape(num_particles, num_objects, 3)


def support_normals(
    points: np.ndarray, normals: np.ndarray, first: np.ndarray
) -> np.ndarray:
    """Returns the unit normals of flat supports, (g, 3), or zeros.

    Args:
        points: (n, 3) where objects touch fixed things (in meters), group
            after group.
        normals: (n, 3) unit normals there, towards the object.
        first: (g,) where each group of contacts begins.
    """
    counts = np.diff(np.append(first, len(points)))
    total = np.add.reduceat(normals, first)
    length = np.linalg.norm(total, axis=1)
    along = np.sum(normals * np.repeat(total, counts, axis=0), axis=1)
    agree = np.minimum.reduceat(along, first) >= _SAME_DIRECTION * length
    offsets = points - np.repeat(points[first], counts, axis=0)
    squared = np.sum(offsets * offsets, axis=1)
    furthest = np.maximum.reduceat(squared, first)
    is_furthest = squared == np.repeat(furthest, counts)
    index = np.where(is_furthest, np.arange(len(points)), len(points))
    direction = offsets[np.minimum.reduceat(index, first)]
    dot = np.sum(offsets * np.repeat(direction, counts, axis=0), axis=1)
    # The squared distances from the line through the first and the furthest
    # point, times the squared length of that line.
    across = squared * np.repeat(furthest, counts) - dot * dot
    wide = np.maximum.reduceat(across, first) >= _MIN_WIDTH**2 * furthest
    flat = (counts >= 3) & (length > 0) & agree & wide & (furthest > 0)
    return (
        np.where(flat[:, None], total, 0.0) / np.where(flat, length, 1)[:, None]
    )
