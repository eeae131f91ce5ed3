"""Poses as arrays, from and to Drake's RigidTransform.

An array is (7,): qw qx qy qz, x y z (in meters).
"""

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform


def pose_array(X_WO: RigidTransform) -> np.ndarray:
    """Returns a pose as an array (7,)."""
    q = X_WO.rotation().ToQuaternion().wxyz()
    return np.concatenate([q, X_WO.translation()])


def rigid_transform(pose: np.ndarray) -> RigidTransform:
    """Returns a pose (7,), whose quaternion may have any length but 0."""
    return RigidTransform(
        Quaternion(pose[:4] / np.linalg.norm(pose[:4])), pose[4:]
    )
