"""How the links of the robot move while its joints follow their path.

The robot's motion is measured and the same for all particles, so it needn't be
simulated. The poses of its links are calculated once, at some times; between
these each link moves at a steady velocity.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.systems.framework import Context

from pbpf_drake.motion.control_path import ControlPath, simplify_path
from pbpf_drake.motion.ticks import to_ticks
from pbpf_drake.poses import quaternions
from pbpf_drake.scene.prediction_model import PredictionModel
from pbpf_drake.shapes.bounding_boxes import BoundingBoxes, MakeBoundingBoxes

# How far any part of a link may be from where it really was (in meters).
_TOLERANCE = 5e-4

# Some of the robot's links, in ascending order: indices into
# PredictionModel.links.
LinkSet = tuple[int, ...]


@dataclass(frozen=True)
class LinkMotion:
    """The motion of L links in S - 1 pieces, each at a steady velocity.

    Attributes:
        times: (S,) at which pieces begin and end: from 0, ascending, in whole
            ticks (in seconds).
        poses: (S, L, 7) of the links then: qw qx qy qz, x y z (in meters).
        velocities: (S - 1, L, 6) in between: angular (rad/s), then
            translational (m/s), in the world.
        speed: the highest of any part of a link (in m/s).
        travel: the longest way of any part of a link (in meters).
    """

    times: np.ndarray
    poses: np.ndarray
    velocities: np.ndarray
    speed: float
    travel: float

    def of(self, link_set: Sequence[int]) -> "LinkMotion":
        """Returns the motion of some of the links, by their indices."""
        rows = list(link_set)
        return replace(
            self, poses=self.poses[:, rows], velocities=self.velocities[:, rows]
        )


class RobotLinks:
    """The kinematics of a robot's links, and their bounding boxes.

    Args:
        model: the scene's models.
    """

    def __init__(self, *, model: PredictionModel) -> None:
        self._model = model
        self.boxes: BoundingBoxes = MakeBoundingBoxes(
            model.diagram.scene_graph().model_inspector(),
            [model.geometries(link) for link in model.links],
        )

    def Poses(self, positions: np.ndarray, context: Context) -> np.ndarray:
        """Returns the poses of all links, (L, 7).

        Args:
            positions: (n,) of the robot's joints.
            context: of the model's plant, overwritten.
        """
        return self._Poses(np.asarray(positions)[None], context)[0]

    def Motion(self, path: ControlPath, context: Context) -> LinkMotion:
        """Returns how all links move while the joints follow a path.

        Args:
            path: of the joints.
            context: of the model's plant, overwritten.
        """
        poses = self._Poses(path.positions, context)
        corners = self.boxes.at(poses).corners()
        simple = simplify_path(
            ControlPath(path.times, corners.reshape(len(poses), -1)), _TOLERANCE
        )
        kept = np.searchsorted(path.times, simple.times)
        times = simple.times - simple.times[0]
        ways = np.linalg.norm(np.diff(corners[kept], axis=0), axis=-1)
        speeds = ways / np.diff(times)[:, None, None]
        return LinkMotion(
            times=to_ticks(times),
            poses=poses[kept],
            velocities=_velocities(times, poses[kept]),
            speed=float(speeds.max(initial=0.0)),
            travel=float(ways.sum(axis=0).max(initial=0.0)),
        )

    def _Poses(self, positions: np.ndarray, context: Context) -> np.ndarray:
        """Returns poses (S, L, 7) for positions (S, n)."""
        plant = self._model.diagram.plant()
        port = plant.get_body_poses_output_port()
        rows = [int(link) for link in self._model.links]
        q = plant.GetPositions(context)
        poses = []
        for q[self._model.robot_q] in positions:
            plant.SetPositions(context, q)
            X_WB = port.Eval(context)
            poses += [X_WB[row].GetAsMatrix34() for row in rows]
        X = np.reshape(poses, (len(positions), len(rows), 3, 4))
        return np.concatenate(
            [quaternions.from_matrix(X[..., :3]), X[..., 3]], axis=-1
        )


def _velocities(times: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Returns the steady velocities from pose to pose, (S - 1, L, 6)."""
    q, p = poses[..., :4], poses[..., 4:]
    turn = quaternions.multiply(q[1:], quaternions.conjugate(q[:-1]))
    change = np.concatenate(
        [quaternions.to_rotation_vector(turn), np.diff(p, axis=0)], axis=-1
    )
    return change / np.diff(times)[:, None, None]
