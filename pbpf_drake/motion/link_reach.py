"""How near the links of the robot come to the objects of the particles."""

import numpy as np

from pbpf_drake.shapes.bounding_boxes import (
    BoundingBoxes,
    PlacedBoxes,
    least_distances,
)


def link_distances(
    *,
    object_boxes: BoundingBoxes,
    poses: np.ndarray,
    active: np.ndarray,
    link_boxes: BoundingBoxes,
    link_poses: np.ndarray,
    margin: np.ndarray,
) -> np.ndarray:
    """Returns a lower bound of each link's distance from all objects, (M, L).

    It is inf (in meters) where it is more than the margin.

    Args:
        object_boxes: boxes around K objects.
        poses: (M, K, 7) of the objects; what isn't finite is near nothing.
        active: (K,) which objects count.
        link_boxes: boxes around L links.
        link_poses: (S, L, 7) of the links, at S times.
        margin: (M,) the largest distance of interest (in meters).
    """
    found = np.full((len(poses), link_poses.shape[1]), np.inf)
    with np.errstate(invalid="ignore", over="ignore"):
        objects = object_boxes.at(poses[:, None])
        objects = objects.subset(active[object_boxes.bodies])
        links = link_boxes.at(link_poses)
        links = links.subset(_may_be_near(objects, links, margin))
        distances = least_distances(objects, links).min(
            axis=(1, 2), initial=np.inf
        )
    for box, link in enumerate(links.bodies):
        found[:, link] = np.fmin(found[:, link], distances[:, box])
    return np.where(found <= margin[:, None], found, np.inf)


def _may_be_near(
    objects: PlacedBoxes, links: PlacedBoxes, margin: np.ndarray
) -> np.ndarray:
    """Returns which boxes of links may come near any object, (G,).

    A sphere around such a box comes as near as the margin.

    Args:
        objects: boxes of M particles, (M, 1, ...).
        links: boxes at S times, (S, ...).
        margin: (M,) as in link_distances.
    """
    offset = links.centers[:, None] - objects.centers[..., None, :]
    seen = np.abs(offset @ objects.axes)  # (M, S, objects, links, 3)
    beyond = np.maximum(seen - objects.half_sizes[:, None], 0.0)
    radii = np.linalg.norm(links.half_sizes, axis=-1)
    reach = margin[:, None, None, None] + radii
    distances = np.sqrt(np.einsum("...i,...i", beyond, beyond))
    return (distances <= reach).any(axis=(0, 1, 2))
