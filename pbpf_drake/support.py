"""Which objects stand on something fixed, and in which direction it carries.

An object at rest on a table can slide and turn on it, but noise that lifts or
tilts it would only make it fall back. So noise is restricted to what the
support leaves free.
"""

import math

import numpy as np
from pydrake.systems.framework import Context

from pbpf_drake.prediction_model import PredictionModel

# A support is flat where the normals of its contacts agree (cos of 3°) ...
_SAME_DIRECTION = 0.9986
# ... and its contacts are this far from lying on one line (in meters).
_SPREAD = 2e-3


def support_normal(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Returns the unit normal of a flat support, (3,), or zeros.

    Args:
        points: (n, 3) where an object touches fixed things (in meters).
        normals: (n, 3) unit normals there, towards the object.
    """
    if len(points) < 3:
        return np.zeros(3)
    total = normals.sum(axis=0)
    length = math.sqrt(total @ total)
    if length == 0 or (normals @ total).min() < _SAME_DIRECTION * length:
        return np.zeros(3)
    offsets = points - points[0]
    squared = np.einsum("ni,ni->n", offsets, offsets)
    furthest = squared.argmax()
    along = offsets @ offsets[furthest]
    # Squared distances from the line to the furthest point, times its length.
    across = squared * squared[furthest] - along * along
    if across.max() < _SPREAD**2 * squared[furthest] or not squared.any():
        return np.zeros(3)
    return total / length


def find_supports(model: PredictionModel, context: Context) -> np.ndarray:
    """Returns support_normal of every object, (K, 3).

    A thing that carries a weight is penetrated a little, so what touches can
    be read off the penetrations.

    Args:
        model: the prediction model.
        context: a root context of its diagram.
    """
    scene_graph = model.diagram.scene_graph()
    query = scene_graph.get_query_output_port().Eval(
        scene_graph.GetMyContextFromRoot(context)
    )
    contacts: list[list] = [[] for _ in model.object_geometries]
    for pair in query.ComputePointPairPenetration():
        a, b = model.owner(pair.id_A), model.owner(pair.id_B)
        if a is not None and pair.id_B in model.fixed_geometries:
            contacts[a].append((pair.p_WCa, pair.nhat_BA_W))
        elif b is not None and pair.id_A in model.fixed_geometries:
            contacts[b].append((pair.p_WCb, -pair.nhat_BA_W))
    return np.array(
        [
            support_normal(*np.array(c).swapaxes(0, 1)) if c else np.zeros(3)
            for c in contacts
        ]
    )
