"""Moves objects out of what they penetrate, before they are simulated.

Noise puts particles into the table and into the hand. A physics engine would
shoot them out. Here they are pushed out instead, along the normal of the
deepest penetration, until nothing is deep. What stands on something is not
lifted by the robot, but slid.
"""

from collections.abc import Sequence

import numpy as np
from pydrake.geometry import PenetrationAsPointPair
from pydrake.systems.framework import Context

from pbpf_drake.contact_model import ContactModel
from pbpf_drake.contact_points import REST_DEPTH

# What is left of a penetration (in meters). Of one by what may carry an object
# it is that of an object at rest, or it would fall.
TOUCH = 8e-5
# What is deeper than this times as much is pushed out.
_TOLERANCE = 1.25
# Each push makes some way for one contact; a box between hand, table and
# another box needs a few.
_MAX_PUSHES = 10
# What was pushed isn't pushed back: within 60° of it.
_BACK = 0.5
# An object is slid along its support where that is at most twice as far as
# along the normal.
_MIN_SLIDE = 0.5


class PenetrationResolver:
    """Moves objects out of links, fixed models and each other.

    Args:
        model: the contact model.
        context: a root context of its diagram, overwritten.
    """

    def __init__(self, model: ContactModel, context: Context) -> None:
        plant, scene_graph = model.diagram.plant(), model.diagram.scene_graph()
        self._model = model
        self._plant = plant
        self._context = plant.GetMyMutableContextFromRoot(context)
        self._geometry = scene_graph.GetMyContextFromRoot(context)
        self._query = scene_graph.get_query_output_port()

    def PushOut(self, q: np.ndarray, supports: np.ndarray) -> np.ndarray:
        """Returns q with the objects moved.

        Of two objects that penetrate, each goes half the way, unless one of
        them would go back to where it was pushed from. Rotations are kept.

        Args:
            q: (nq,) positions of the model's plant; the links' are kept.
            supports: (K, 3) normals of what the objects stand on, or zeros.
        """
        q = q.copy()
        pushed: list[list[np.ndarray]] = [[] for _ in supports]
        for _ in range(_MAX_PUSHES):
            self._plant.SetPositions(self._context, q)
            query = self._query.Eval(self._geometry)
            pairs = query.ComputePointPairPenetration()
            deepest = _deepest(self._model, pairs)
            if deepest is None:
                break
            _push(self._model, q, *deepest, supports, pushed)
        return q


def is_too_deep(depth: np.ndarray, upwards: np.ndarray) -> np.ndarray:
    """Returns which penetrations by fixed models or objects are too deep.

    Args:
        depth: (...) of the penetrations (in meters).
        upwards: (...) the z components of their normals.
    """
    return depth > _TOLERANCE * np.maximum(TOUCH, REST_DEPTH * np.abs(upwards))


def _deepest(
    model: ContactModel, pairs: Sequence[PenetrationAsPointPair]
) -> tuple[PenetrationAsPointPair, float] | None:
    """Returns what is the most too deep, and how far it has to be pushed."""
    deepest, most = None, 0.0
    links = model.link_geometries
    for pair in pairs:
        depth, left = pair.depth, TOUCH
        if depth <= _TOLERANCE * TOUCH + most:
            continue
        if pair.id_A not in links and pair.id_B not in links:
            left = max(TOUCH, REST_DEPTH * abs(float(pair.nhat_BA_W[2])))
        if depth - _TOLERANCE * left > most:
            deepest, most = (pair, depth - left), depth - _TOLERANCE * left
    return deepest


def _push(
    model: ContactModel,
    q: np.ndarray,
    pair: PenetrationAsPointPair,
    distance: float,
    supports: np.ndarray,
    pushed: list[list[np.ndarray]],
) -> None:
    """Moves what penetrates, and notes what can't go back any more.

    Args:
        model: the contact model.
        q: (nq,) changed.
        pair: what penetrates.
        distance: the way that they have to go apart (in meters).
        supports: (K, 3) as in PushOut.
        pushed: the directions in which each object was pushed by what doesn't
            give way; extended.
    """
    fixed = {pair.id_A, pair.id_B} & model.fixed_geometries
    sides = [
        (model.owners.get(pair.id_A), pair.nhat_BA_W),
        (model.owners.get(pair.id_B), -pair.nhat_BA_W),
    ]
    free = [
        k is not None and all(normal @ way > -_BACK for way in pushed[k])
        for k, normal in sides
    ]
    if not any(free):
        free = [k is not None for k, _ in sides]
    for (k, normal), goes in zip(sides, free, strict=True):
        if k is None or not goes:
            continue
        along = normal if fixed else _slide(normal, supports[k])
        q[model.object_q[k, 4:]] += distance / sum(free) * along
        if sum(free) == 1:
            pushed[k].append(normal)


def _slide(normal: np.ndarray, support: np.ndarray) -> np.ndarray:
    """Returns the way along a support that goes 1 along a normal."""
    along = normal - (normal @ support) * support
    share = along @ along
    return along / share if share >= _MIN_SLIDE else normal
