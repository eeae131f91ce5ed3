"""How near the links of the robot come to the objects of the particles."""

import numpy as np

from pbpf_drake.shapes.bounding_boxes import (
    BoundingBoxes,
    PlacedBoxes,
    least_distances,
)


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
    with np.errstate(invalid="ignore", over="ignore"):
        near = objects.at(poses[:, None]).subset(active[objects.bodies])
        boxes = links.at(link_poses)
        boxes = boxes.subset(_may_be_near(near, boxes, margin))
        distances = least_distances(near, boxes).min(
            axis=(1, 2), initial=np.inf
        )
    for box, link in enumerate(boxes.bodies):
        found[:, link] = np.fmin(found[:, link], distances[:, box])
    return np.where(found <= margin[:, None], found, np.inf)


def _may_be_near(
    objects: PlacedBoxes, links: PlacedBoxes, margin: np.ndarray
) -> np.ndarray:
    """Returns which boxes of links have a sphere that comes near, (G,).

    Args:
        objects: of M particles, (M, 1, ...).
        links: at S times, (S, ...).
        margin: (M,).
    """
    offset = links.centers[:, None] - objects.centers[..., None, :]
    seen = np.abs(offset @ objects.axes)  # (M, S, objects, links, 3)
    beyond = np.maximum(seen - objects.half_sizes[:, None], 0.0)
    radii = np.linalg.norm(links.half_sizes, axis=-1)
    reach = margin[:, None, None, None] + radii
    distances = np.sqrt(np.einsum("...i,...i", beyond, beyond))
    return (distances <= reach).any(axis=(0, 1, 2))
