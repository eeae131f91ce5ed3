"""Which links of the robot may come near the objects of which particles."""

import numpy as np

from pbpf_drake.bounding_boxes import BoundingBoxes, least_distances


def links_in_reach(
    *,
    objects: BoundingBoxes,
    poses: np.ndarray,
    active: np.ndarray,
    links: BoundingBoxes,
    link_poses: np.ndarray,
    margin: np.ndarray,
) -> np.ndarray:
    """Returns which links come near an object of a particle, (M, L).

    Args:
        objects: boxes around K objects.
        poses: (M, K, 7) of the objects; what isn't finite is near nothing.
        active: (K,) which objects count.
        links: boxes around L links.
        link_poses: (S, L, 7) of the links, at S times.
        margin: (M,) the distance that counts as near (in meters).
    """
    with np.errstate(invalid="ignore", over="ignore"):
        distances = least_distances(
            objects, poses[:, None], links, link_poses[None]
        ).min(axis=1)
    close = distances <= margin[:, None, None]
    close = close[:, active[objects.bodies]].any(axis=1)
    near = np.zeros((len(poses), link_poses.shape[1]), dtype=bool)
    for box, link in enumerate(links.bodies):
        near[:, link] |= close[:, box]
    return near
