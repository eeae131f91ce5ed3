"""Shapes and colors of models, and how tracked objects are drawn.

A tracked object is drawn several times over: solid where it is estimated to
be, and as ghosts and outlines where it is detected, and where it truly is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import (
    Box,
    CalcObb,
    Convex,
    FrameId,
    Mesh,
    Meshcat,
    Rgba,
    Role,
    SceneGraphInspector,
    Shape,
)
from pydrake.math import RigidTransform

ESTIMATE_COLOR = Rgba(0.1, 0.75, 0.3)
DETECTION_COLOR = Rgba(1.0, 0.8, 0.0)
TRUTH_COLOR = Rgba(0.1, 0.3, 1.0)

# What is covered up to this (in meters) is painted on, not a part.
_PAINT = 1e-3


@dataclass(frozen=True)
class VisualGeometry:
    """One illustration geometry G of a body B.

    Attributes:
        shape: in its frame G.
        X_BG: pose in the body.
        rgba: its color.
    """

    shape: Shape
    X_BG: RigidTransform
    rgba: Rgba


def GetVisualGeometries(
    inspector: SceneGraphInspector, frame: FrameId
) -> list[VisualGeometry]:
    """Returns the illustration geometry of the body that has this frame."""
    geometries = []
    for geometry in inspector.GetGeometries(frame, Role.kIllustration):
        properties = inspector.GetIllustrationProperties(geometry)
        rgba = properties.GetPropertyOrDefault(
            "phong", "diffuse", Rgba(0.9, 0.9, 0.9)
        )
        geometries.append(
            VisualGeometry(
                shape=inspector.GetShape(geometry),
                X_BG=inspector.GetPoseInFrame(geometry),
                rgba=rgba,
            )
        )
    return geometries


def DrawGeometries(
    meshcat: Meshcat,
    path: str,
    geometries: Sequence[VisualGeometry],
    *,
    tint: Rgba | None = None,
) -> None:
    """Sets the objects ``path/0``, ``path/1``, … at their poses in ``path``.

    Args:
        meshcat: where to draw.
        path: of the body.
        geometries: what to draw.
        tint: a color that theirs are mixed with, half and half.
    """
    for i, geometry in enumerate(geometries):
        rgba = geometry.rgba if tint is None else _mix(geometry.rgba, tint)
        meshcat.SetObject(f"{path}/{i}", geometry.shape, rgba)
        meshcat.SetTransform(f"{path}/{i}", geometry.X_BG)
        if tint is not None and isinstance(geometry.shape, Mesh):
            # A mesh has its own materials, which rgba doesn't replace.
            color = [tint.r(), tint.g(), tint.b(), tint.a()]
            meshcat.SetProperty(f"{path}/{i}", "color", color)


def MakeSilhouette(
    geometries: Sequence[VisualGeometry], color: Rgba, opacity: float
) -> list[VisualGeometry]:
    """Returns a simple likeness in one color, to be drawn many times.

    Meshes become their boxes, which keeps files small, and what a bigger
    geometry covers, as a label on a box, is left out.

    Args:
        geometries: of one body.
        color: of the likeness.
        opacity: from 0 to 1.
    """
    rgba = Rgba(color.r(), color.g(), color.b(), opacity)
    boxes = [_bounding_box(g) for g in geometries]
    order = sorted(range(len(boxes)), key=lambda i: -np.prod(boxes[i][1]))
    kept: list[int] = []
    for i in order:
        corners = _corners(*boxes[i])
        if not any(_covers(boxes[j], corners) for j in kept):
            kept.append(i)
    likeness = []
    for i in kept:
        shape, X_BG = geometries[i].shape, geometries[i].X_BG
        if isinstance(shape, Mesh | Convex):
            X_BG, half = boxes[i]
            shape = Box(*(2 * half))
        likeness.append(VisualGeometry(shape, X_BG, rgba))
    return likeness


def DrawOutline(
    meshcat: Meshcat,
    path: str,
    geometries: Sequence[VisualGeometry],
    rgba: Rgba,
) -> None:
    """Draws the edges of the box around all geometries as lines at ``path``."""
    corners = np.vstack([_corners(*_bounding_box(g)) for g in geometries])
    low, high = corners.min(axis=0), corners.max(axis=0)
    box = _corners(RigidTransform(0.5 * (low + high)), 0.5 * (high - low))
    edges = [(i, i | bit) for i in range(8) for bit in (1, 2, 4) if not i & bit]
    start, end = box[np.array(edges).T]
    meshcat.SetLineSegments(
        path,
        start=np.asfortranarray(start.T),
        end=np.asfortranarray(end.T),
        line_width=3.0,
        rgba=rgba,
    )


def _mix(rgba: Rgba, tint: Rgba) -> Rgba:
    mixed = 0.5 * (
        np.array([rgba.r(), rgba.g(), rgba.b()])
        + np.array([tint.r(), tint.g(), tint.b()])
    )
    return Rgba(*mixed, tint.a())


def _bounding_box(
    geometry: VisualGeometry,
) -> tuple[RigidTransform, np.ndarray]:
    """Returns X_BA and half the size (3,) of a box A around the geometry."""
    box = CalcObb(geometry.shape)
    if box is None:
        raise ValueError(
            f"{geometry.shape} is illustration of a tracked object; expected "
            "a shape with a size"
        )
    return geometry.X_BG @ box.pose(), np.asarray(box.half_width())


def _corners(X_BA: RigidTransform, half: np.ndarray) -> np.ndarray:
    """Returns the 8 corners of a box in B, (8, 3); bit i of a row: +axis i."""
    bits = (np.arange(8)[:, None] >> np.arange(3)) & 1
    return (X_BA @ ((2 * bits - 1) * half).T).T


def _covers(
    box: tuple[RigidTransform, np.ndarray], corners: np.ndarray
) -> bool:
    X_BA, half = box
    p_A = (X_BA.inverse() @ corners.T).T
    return bool(np.all(np.abs(p_A) <= half + _PAINT))
