"""Which objects stand on something fixed, and in which direction it carries.

An object at rest on a table can slide and turn on it, but noise that lifts or
tilts it would only make it fall back. So noise is restricted to what the
support leaves free.
"""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import Context

from pbpf_drake.contact_model import ContactModel

# A support is flat where the normals of its contacts agree (cos of 3°) ...
_SAME_DIRECTION = 0.9986
# ... and its contacts are this far from lying on one line (in meters).
_SPREAD = 2e-3
# An object, a point of it, and the normal there, towards the object.
Contact = tuple[int, np.ndarray, np.ndarray]


def find_contacts(model: ContactModel, context: Context) -> list[Contact]:
    """Returns where objects touch fixed models.

    A thing that carries a weight is penetrated a little, so what touches can
    be read off the penetrations.

    Args:
        model: the contact model.
        context: a root context of its diagram.
    """
    scene_graph = model.diagram.scene_graph()
    query = scene_graph.get_query_output_port().Eval(
        scene_graph.GetMyContextFromRoot(context)
    )
    contacts = []
    for pair in query.ComputePointPairPenetration():
        a, b = pair.id_A, pair.id_B
        if b in model.fixed_geometries and a in model.owners:
            contacts.append((model.owners[a], pair.p_WCa, pair.nhat_BA_W))
        elif a in model.fixed_geometries and b in model.owners:
            contacts.append((model.owners[b], pair.p_WCb, -pair.nhat_BA_W))
    return contacts


def find_supports(
    contacts: Sequence[Sequence[Contact]], num_objects: int
) -> np.ndarray:
    """Returns the flat support of every object of M particles, (M, K, 3).

    It is the unit normal of at least three contacts that agree in direction
    and are not on one line; zeros where there is no such support.

    Args:
        contacts: of each particle.
        num_objects: K.
    """
    supports = np.zeros((len(contacts) * num_objects, 3))
    flat = [
        (m * num_objects + k, point, normal)
        for m, of_particle in enumerate(contacts)
        for k, point, normal in of_particle
    ]
    if not flat:
        return supports.reshape(len(contacts), num_objects, 3)
    flat.sort(key=lambda contact: contact[0])
    owners, first = np.unique([c[0] for c in flat], return_index=True)
    points = np.array([c[1] for c in flat])
    normals = np.array([c[2] for c in flat])
    supports[owners] = support_normals(points, normals, first)
    return supports.reshape(len(contacts), num_objects, 3)


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
    # Squared distances from the line to the furthest point, times its length.
    across = squared * np.repeat(furthest, counts) - dot * dot
    spread = np.maximum.reduceat(across, first) >= _SPREAD**2 * furthest
    flat = (counts >= 3) & (length > 0) & agree & spread & (furthest > 0)
    return (
        np.where(flat[:, None], total, 0.0) / np.where(flat, length, 1)[:, None]
    )
