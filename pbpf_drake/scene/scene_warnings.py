"""What can be simulated, but probably not as it was meant."""

from collections.abc import Iterable, Sequence
import logging

import numpy as np
from pydrake.geometry import GeometryId, HalfSpace, SceneGraphInspector

from pbpf_drake.shapes.bounding_boxes import (
    BoundingBoxes,
    MakeBoundingBoxes,
    PlacedBoxes,
    least_distances,
)

# How far below an object what carries it may be (in meters): about as far as
# the pose in a scene file may be from where the object is first detected.
_REACH = 0.5
_said: set[str] = set()


def WarnOnce(warnings: Iterable[str]) -> None:
    """Says in Python's log what this process hasn't said there yet.

    The models of a scene are parsed several times: for the filter, for its
    pictures, and so on.
    """
    for warning in warnings:
        if warning not in _said:
            _said.add(warning)
            logging.getLogger(__name__).warning("%s", warning)


def robot_warnings(
    robot: str, link_names: Sequence[str], num_colliding: int
) -> list[str]:
    """Returns a warning if no link of a robot can touch anything.

    Args:
        robot: the name of its model.
        link_names: of all its links.
        num_colliding: how many of them have collision geometry.
    """
    if num_colliding:
        return []
    return [
        f"robot {robot!r} has no collision geometry on any of its links "
        f"({', '.join(link_names)}), so it can neither push nor hide anything: "
        "give its links <collision> elements, of boxes, cylinders or meshes"
    ]


def CarrierWarnings(
    *,
    inspector: SceneGraphInspector,
    names: Sequence[str],
    objects: Sequence[Sequence[GeometryId]],
    poses: np.ndarray,
    fixed: Sequence[Sequence[GeometryId]],
    fixed_poses: np.ndarray,
) -> list[str]:
    """Returns a warning for each object that nothing carries.

    An object is carried by a fixed body that is below it, or by an object that
    is carried.

    Args:
        inspector: knows the geometries.
        names: of the K objects.
        objects: the collision geometries of each of them.
        poses: (K, 7) where the scene puts them.
        fixed: the collision geometries of each of the F fixed bodies.
        fixed_poses: (F, 7) of these, in the world.

    Raises:
        ValueError: an object has a geometry without bounds.
    """
    shapes = [inspector.GetShape(g) for body in fixed for g in body]
    if any(isinstance(shape, HalfSpace) for shape in shapes):
        return []  # A floor without an end carries everything.
    carried = find_carried(
        MakeBoundingBoxes(inspector, objects),
        poses,
        MakeBoundingBoxes(inspector, fixed).at(fixed_poses),
    )
    return [
        f"nothing carries {name!r} where the scene puts it, at "
        f"{pose[4:].round(3).tolist()} m: no fixed model is within "
        f"{_REACH:g} m below it, so unless the robot holds it, it falls "
        "whenever it isn't detected; weld a table or a floor to the world, or "
        "correct its default_free_body_pose"
        for name, pose, own, is_carried in zip(
            names, poses, objects, carried, strict=True
        )
        if own and not is_carried
    ]


def find_carried(
    boxes: BoundingBoxes, poses: np.ndarray, fixed: PlacedBoxes
) -> np.ndarray:
    """Returns which of K objects have something below them, (K,).

    Args:
        boxes: around the objects.
        poses: (K, 7) of the objects.
        fixed: boxes around what is fixed.
    """
    placed = boxes.at(poses)
    columns = [
        _column_below(placed.subset(placed.bodies == k))
        for k in range(len(poses))
    ]
    carried = np.array([_touch(column, fixed) for column in columns], bool)
    for _ in poses:  # As many as can be stacked.
        for k, column in enumerate(columns):
            others = carried[placed.bodies] & (placed.bodies != k)
            carried[k] |= _touch(column, placed.subset(others))
    return carried


def _column_below(boxes: PlacedBoxes) -> PlacedBoxes:
    """Returns what is below the middle of an object, as far as the reach."""
    corners = boxes.corners().reshape(-1, 3)
    if not len(corners):
        return boxes
    low, high = corners.min(axis=0), corners.max(axis=0)
    high[2] = (low[2] + high[2]) / 2
    low[2] -= _REACH
    return PlacedBoxes(
        bodies=np.zeros(1, int),
        centers=(low + high)[None] / 2,
        axes=np.eye(3)[None],
        half_sizes=(high - low)[None] / 2,
    )


def _touch(a: PlacedBoxes, b: PlacedBoxes) -> bool:
    return bool((least_distances(a, b) <= 0).any())
