from dataclasses import replace
import math
import re

import numpy as np
from pydrake.common.schema import Rotation, Transform, UniformVector
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
@pytest.mark.parametrize("bad", [0, -1.0, 2_000_000_000, 1e200, 10**400])
def test_sizes_are_positive(field, bad):
    camera = replace(CameraConfig(), **{field: bad})
    limits = {"f": "at least 0.01 and at most 1,000,000"}
    expected = limits.get(field[0], "more than 0 and at most 10,000")
    value = re.escape(repr(bad)[:60])
    expected = rf"^camera\.{field} is {value}…?; expected {expected}$"
    with pytest.raises(ValueError, match=expected):
        camera.ValidateOrThrow("camera")


@pytest.mark.parametrize("field", ["width", "height", "fx", "fy", "cx", "cy"])
@pytest.mark.parametrize("bad", [math.nan, math.inf, -1e200])
def test_intrinsics_are_finite(field, bad):
    camera = replace(CameraConfig(), **{field: bad})
    expected = (
        rf"^camera\.{field} is {re.escape(repr(bad))}; expected .* 10*[,0]+$"
    )
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
        (
            Transform(rotation=Rotation.Rpy(deg=[np.nan, 0, 0])),
            "X_WC is not finite",
        ),
        (
            Transform(rotation=Rotation.Rpy(deg=[np.inf, 0, 0])),
            "X_WC is not finite",
        ),
        (
            Transform(translation=[1e200, 0, 0]),
            r"X_WC.translation is \[1e\+200, 0.0, 0.0\]; expected .* 10000 m",
        ),
    ],
)
def test_the_pose_is_one_pose_in_the_world(X_WC, expected):
    with pytest.raises(ValueError, match=expected):
        CameraConfig(X_WC=X_WC).ValidateOrThrow("camera")
