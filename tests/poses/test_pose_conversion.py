import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from pbpf_drake.poses.pose_conversion import pose_array, rigid_transform


def test_a_pose_array_is_the_quaternion_then_the_position():
    X_WO = RigidTransform(RollPitchYaw(0.0, 0.0, np.pi / 2), [1.0, 2.0, 3.0])
    half = np.sqrt(0.5)
    np.testing.assert_allclose(
        pose_array(X_WO), [half, 0.0, 0.0, half, 1.0, 2.0, 3.0], atol=1e-15
    )


def test_there_and_back_gives_the_same_pose():
    X_WO = RigidTransform(RollPitchYaw(0.3, -0.5, 2.0), [-0.1, 0.2, 0.7])
    assert rigid_transform(pose_array(X_WO)).IsNearlyEqualTo(X_WO, 1e-14)


def test_a_quaternion_that_rounding_has_stretched_is_accepted():
    pose = pose_array(RigidTransform([1.0, 2.0, 3.0]))
    pose[:4] *= 1 + 1e-9
    assert rigid_transform(pose).IsNearlyEqualTo(
        RigidTransform([1.0, 2.0, 3.0]), 1e-14
    )
