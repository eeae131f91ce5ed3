"""Poses as arrays (7,): qw qx qy qz, x y z (in meters), and as Drake's."""

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform


def pose_array(X_WO: RigidTransform) -> np.ndarray:
    """Returns (7,): qw qx qy qz, x y z (in meters)."""
    q = X_WO.rotation().ToQuaternion().wxyz()
    return np.concatenate([q, X_WO.translation()])


def rigid_transform(pose: np.ndarray) -> RigidTransform:
    """Returns the pose (7,) as a RigidTransform."""
    return RigidTransform(
        Quaternion(pose[:4] / np.linalg.norm(pose[:4])), pose[4:]
    )
