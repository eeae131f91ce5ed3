"""How near the links of the robot come to the objects of the particles."""

import numpy as np

from pbpf_drake.bounding_boxes import BoundingBoxes, least_distances


def link_distances(
    *,
    objects: BoundingBoxes,
    poses: np.ndarray,
    active: np.ndarray,
    links: BoundingBoxes,
    link_poses: np.ndarray,
    margin: np.ndarray,
) -> np.ndarray:
    """Returns how far links are from any object at least, (M, L).

    Inf stands for more than the margin.

    Args:
        objects: boxes around K objects.
        poses: (M, K, 7) of the objects; what isn't finite is near nothing.
        active: (K,) which objects count.
        links: boxes around L links.
        link_poses: (S, L, 7) of the links, at S times.
        margin: (M,) the largest distance of interest (in meters).
    """
    found = np.full((len(poses), link_poses.shape[1]), np.inf)
    objects = objects.subset(active[objects.bodies])
    with np.errstate(invalid="ignore", over="ignore"):
        links = links.subset(
            _may_be_near(objects, poses, links, link_poses, margin)
        )
        distances = least_distances(
            objects, poses[:, None], links, link_poses[None]
        ).min(axis=(1, 2), initial=np.inf)
    for box, link in enumerate(links.bodies):
        found[:, link] = np.fmin(found[:, link], distances[:, box])
    return np.where(found <= margin[:, None], found, np.inf)


def _may_be_near(
    objects: BoundingBoxes,
    poses: np.ndarray,
    links: BoundingBoxes,
    link_poses: np.ndarray,
    margin: np.ndarray,
) -> np.ndarray:
    """Returns which boxes of links have a sphere that comes near, (G,)."""
    p_O, _ = objects.frames(poses)
    p_L, _ = links.frames(link_poses)
    offset = p_O[:, None, :, None] - p_L[None, :, None]
    radii = np.linalg.norm(objects.half_sizes, axis=-1)[
        :, None
    ] + np.linalg.norm(links.half_sizes, axis=-1)
    reach = margin[:, None, None, None] + radii
    return (np.linalg.norm(offset, axis=-1) <= reach).any(axis=(0, 1, 2))
