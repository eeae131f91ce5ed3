"""Moves objects out of what they penetrate, before they are simulated.

Noise puts particles into the table and into the hand. A physics engine would
shoot them out. Here they are pushed out instead, along the normal of the
deepest penetration, until nothing is deep.
"""

import numpy as np
from pydrake.geometry import PenetrationAsPointPair, QueryObject
from pydrake.systems.framework import Context

from pbpf_drake.prediction_model import PredictionModel

# What may remain (in meters): an object at rest is this deep or less.
_TOLERANCE = 1e-4
# Each push makes some way for one contact; a box between hand, table and
# another box needs a few.
_MAX_PUSHES = 10


def push_out(
    model: PredictionModel, context: Context, q: np.ndarray
) -> np.ndarray:
    """Returns q with the objects moved out of robot, models and each other.

    Of two objects that penetrate, each goes half the way. Rotations are kept.

    Args:
        model: the prediction model.
        context: a root context of its diagram, overwritten.
        q: (nq,) positions of its plant; the robot's are kept.
    """
    plant = model.diagram.plant()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    query_port = model.diagram.scene_graph().get_query_output_port()
    query_context = model.diagram.scene_graph().GetMyContextFromRoot(context)
    q = q.copy()
    for _ in range(_MAX_PUSHES):
        plant.SetPositions(plant_context, q)
        query: QueryObject = query_port.Eval(query_context)
        pairs = query.ComputePointPairPenetration()
        if not pairs:
            break
        deepest = max(pairs, key=lambda pair: pair.depth)
        if deepest.depth <= _TOLERANCE:
            break
        _push(model, q, deepest)
    return q


def _push(
    model: PredictionModel, q: np.ndarray, pair: PenetrationAsPointPair
) -> None:
    a, b = model.owner(pair.id_A), model.owner(pair.id_B)
    share = 1.0 if a is None or b is None else 0.5
    push = share * pair.depth * pair.nhat_BA_W
    if a is not None:
        q[model.object_q[a, 4:]] += push
    if b is not None:
        q[model.object_q[b, 4:]] -= push
