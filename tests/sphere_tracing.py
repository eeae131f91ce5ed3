"""A slow reference for rays: sphere tracing with Drake's signed distances."""

import numpy as np
from pydrake.geometry import GeometryId, QueryObject

_SURFACE = 1e-8


def trace(
    query_object: QueryObject, origin: np.ndarray, target: np.ndarray
) -> tuple[float, GeometryId | None]:
    """Walks from the origin as far as no geometry can be, until one is met.

    Returns:
        The parameter t of the first hit and what is hit; inf and None where
        the target is reached.
    """
    d = target - origin
    length = np.linalg.norm(d)
    t = 0.0
    while t <= 1:
        nearest = min(
            query_object.ComputeSignedDistanceToPoint(origin + t * d),
            key=lambda found: found.distance,
        )
        if nearest.distance < _SURFACE:
            return t, nearest.id_G
        t += nearest.distance / length
    return np.inf, None
