from dataclasses import replace
import math

import numpy as np
from pydrake.common.schema import Transform, UniformVector
from pydrake.math import RigidTransform, RollPitchYaw
import pytest

from pbpf_drake.config.camera_config import CameraConfig


def test_the_default_camera_can_be_used():
    CameraConfig().ValidateOrThrow("camera")


def test_the_pose_is_the_one_that_is_configured():
    X_WC = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1.0, 2.0, 3.0])
    camera = CameraConfig(X_WC=Transform(X_WC))
    assert camera.pose().IsNearlyEqualTo(X_WC, 1e-12)


@pytest.mark.parametrize("field", ["width", "height", "fx", "fy"])
@pytest.mark.parametrize("bad", [0, -1.0])
def test_sizes_are_positive(field, bad):
    camera = replace(CameraConfig(), **{field: bad})
    expected = rf"^camera\.{field} is {bad}; expected more than 0$"
    with pytest.raises(ValueError, match=expected):
        camera.ValidateOrThrow("camera")


@pytest.mark.parametrize("field", ["width", "height", "fx", "fy", "cx", "cy"])
@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_intrinsics_are_finite(field, bad):
    camera = replace(CameraConfig(), **{field: bad})
    expected = rf"^camera\.{field} is {bad}; expected a number$"
    with pytest.raises(ValueError, match=expected):
        camera.ValidateOrThrow("camera")


@pytest.mark.parametrize(
    "X_WC, expected",
    [
        (Transform(base_frame="table"), "X_WC.base_frame is 'table'"),
        (
            Transform(translation=UniformVector[3](min=[0] * 3, max=[1] * 3)),
            "X_WC is random",
        ),
        (Transform(translation=np.full(3, np.nan)), "X_WC is not finite"),
    ],
)
def test_the_pose_is_one_pose_in_the_world(X_WC, expected):
    with pytest.raises(ValueError, match=expected):
        CameraConfig(X_WC=X_WC).ValidateOrThrow("camera")
