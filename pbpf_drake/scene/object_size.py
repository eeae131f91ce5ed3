"""Refuses tracked objects that can't be in meters, judging by their size."""

from collections.abc import Sequence

from pydrake.geometry import GeometryId, SceneGraphInspector

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.shapes.bounding_boxes import MakeBoundingBoxes

# How long an object can be (in meters). If it is longer or shorter, its numbers
# are probably in another unit.
_SMALLEST = 2e-3
_LARGEST = 2.0


def CheckObjectSizes(
    *,
    scene: Scene,
    inspector: SceneGraphInspector,
    geometries: Sequence[Sequence[GeometryId]],
) -> None:
    """Checks that no tracked object is too long or too short for meters.

    Args:
        scene: has K tracked models.
        inspector: knows the geometries.
        geometries: the collision geometries of each of the K.

    Raises:
        ValueError: an object has a geometry that is too long, or has none that
            is long enough.
    """
    for name, own in zip(scene.tracked, geometries, strict=True):
        boxes = MakeBoundingBoxes(inspector, [own])
        size = 2 * float(boxes.half_sizes.max(initial=0.0))
        if not own or _SMALLEST <= size <= _LARGEST:
            continue
        hint = "is it scaled from millimetres, though it is in meters?"
        if size > _LARGEST:
            hint = (
                "is its mesh in millimetres? Then write "
                "<scale>0.001 0.001 0.001</scale> beside the mesh's <uri> in "
                "an SDF file, or write the mesh in meters"
            )
        raise ValueError(
            f"Scene {scene.path}: tracked model {name!r} is {size:.3g} m long; "
            f"expected {_SMALLEST:g} to {_LARGEST:g} m: {hint}"
        )
