"""The interface of motion models, and the constant-velocity one (Section 5).

A motion model moves all particles at once. How it does so is its own affair:
the filter hands it arrays and a scratch pad, and gets arrays back.
"""

from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np

from pbpf_drake.motion.control_path import ControlPath
from pbpf_drake.poses import quaternions

# What a motion model works in; nobody else looks into it.
MotionScratch = TypeVar("MotionScratch")


@dataclass(frozen=True)
class MotionInput:
    """What a motion model may use to predict one step.

    Attributes:
        poses: (M, K, 7) the particles: qw qx qy qz, x y z (in meters).
        velocities: (M, K, 6) their angular (rad/s), then translational (m/s)
            velocities in the world.
        active: (K,) whether an object was tracked before this update. The
            others have no known pose; they must not influence anything.
        path: u_t, what the robot did since the last update.
        estimates: (2, K, 7) the estimated poses of the last update and of
            the one before it.
        num_estimates: (K,) how many of the two there are.
        step: count of updates, for MakeGenerator.
    """

    poses: np.ndarray
    velocities: np.ndarray
    active: np.ndarray
    path: ControlPath
    estimates: np.ndarray
    num_estimates: np.ndarray
    step: int


@dataclass(frozen=True)
class MotionResult:
    """Predicted particles x̄.

    Attributes:
        poses: (M, K, 7), all finite.
        velocities: (M, K, 6), all finite.
        supports: (M, K, 3) unit normal of the flat support that an object
            stands on; zeros where it is free, or where that isn't known.
        failed: (M,) particles that could not be predicted. They keep their
            old pose and must not survive.
    """

    poses: np.ndarray
    velocities: np.ndarray
    supports: np.ndarray
    failed: np.ndarray


class MotionModel(Protocol[MotionScratch]):
    """Predicts where objects go. Implementations keep no memory."""

    def MakeScratch(self) -> MotionScratch:
        """Returns work space that the other two may write to.

        Nothing in it may influence a result.
        """

    def Propagate(
        self, motion: MotionInput, scratch: MotionScratch
    ) -> MotionResult:
        """Returns f(x_{t-1}, u_t), without the noise ε."""

    def ResolvePenetration(
        self,
        poses: np.ndarray,
        supports: np.ndarray,
        robot_positions: np.ndarray,
        known: np.ndarray,
        scratch: MotionScratch,
    ) -> np.ndarray:
        """Returns poses (M, K, 7), moved as little as physics asks for.

        Args:
            poses: (M, K, 7).
            supports: (M, K, 3) what the objects stand on, as in MotionResult.
            robot_positions: (n,) where the robot is (in radians or meters).
            known: (K,) whether an object was tracked before this update, or
                is detected in it. The others have no known pose; they must
                not influence anything.
            scratch: from MakeScratch.
        """


class ConstantVelocityMotionModel:
    """x̄_t = x_{t-1} + dx, dx = x̃_{t-1} - x̃_{t-2} (Section 5, CVPF).

    The difference of two estimates is that of their positions and the turn
    from the one's orientation to the other's, both in the world. Until there
    are two estimates, objects stay where they are.
    """

    def MakeScratch(self) -> None:
        """Needs none."""

    def Propagate(self, motion: MotionInput, scratch: None) -> MotionResult:
        """Moves every particle by the last difference of two estimates."""
        last, before = motion.estimates
        moving = motion.active & (motion.num_estimates >= 2)
        dp = np.where(moving[:, None], last[:, 4:] - before[:, 4:], 0.0)
        dq = quaternions.multiply(
            last[:, :4], quaternions.conjugate(before[:, :4])
        )
        dq = np.where(moving[:, None], dq, [1.0, 0.0, 0.0, 0.0])
        q = quaternions.normalize(
            quaternions.multiply(dq, motion.poses[..., :4])
        )
        return MotionResult(
            np.concatenate([q, motion.poses[..., 4:] + dp], axis=-1),
            motion.velocities,
            np.zeros((*motion.poses.shape[:2], 3)),
            np.zeros(len(motion.poses), dtype=bool),
        )

    def ResolvePenetration(
        self,
        poses: np.ndarray,
        supports: np.ndarray,
        robot_positions: np.ndarray,
        known: np.ndarray,
        scratch: None,
    ) -> np.ndarray:
        """Returns the poses as they are: this model knows no contact."""
        return poses
