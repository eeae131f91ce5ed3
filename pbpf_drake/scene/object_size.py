"""Whether tracked objects are given in meters."""

from collections.abc import Sequence

from pydrake.geometry import GeometryId, SceneGraphInspector

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.shapes.bounding_boxes import MakeBoundingBoxes

# How long an object can be (in meters): what is outside of this is in another
# unit.
_SMALLEST = 2e-3
_LARGEST = 2.0


def CheckObjectSizes(
    *,
    scene: Scene,
    inspector: SceneGraphInspector,
    geometries: Sequence[Sequence[GeometryId]],
) -> None:
    """Refuses objects whose numbers can't be meters.

    Args:
        scene: with K tracked models.
        inspector: knows the geometries.
        geometries: the collision geometries of each of the K.

    Raises:
        ValueError: a geometry is too long, or all of an object's are too short.
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
