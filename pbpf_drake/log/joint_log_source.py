"""A system that plays recorded joint states."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from pbpf_drake.log.log_records import JointRecord
from pbpf_drake.log.pose_interpolation import find_segments


def interpolate_joints(
    record: JointRecord, time: float
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the joint positions and velocities at a time.

    Positions are interpolated linearly. So are recorded velocities; without
    them the velocity is the slope of the positions. Before the first and
    after the last sample the robot rests where it was then.

    Args:
        record: the recorded motion of n joints.
        time: since the log's start (in seconds).

    Returns:
        q (n,) in radians or meters, and v (n,) in rad/s or m/s.
    """
    times = record.times
    i, j, u = find_segments(times, np.asarray(time))
    q = (1 - u) * record.positions[i] + u * record.positions[j]
    if not times[0] <= time <= times[-1]:
        return q, np.zeros_like(q)
    if record.velocities is not None:
        v = (1 - u) * record.velocities[i] + u * record.velocities[j]
    elif i == j:
        v = np.zeros_like(q)
    else:
        step = record.positions[j] - record.positions[i]
        v = step / (times[j] - times[i])
    return q, v


class JointLogSource(LeafSystem):
    """Plays recorded joint states.

    .. pydrake_system::

        name: JointLogSource
        output_ports:
        - joint_positions
        - joint_velocities

    Output ``joint_positions``: (n,) the joints' positions at the context's
    time, in the record's order (in radians or meters).

    Output ``joint_velocities``: (n,) their velocities (in rad/s or m/s); zero
    before the record starts and after it ends.

    The context's time 0 is the log's start. See ``interpolate_joints`` for
    what lies between samples.
    """

    def __init__(self, *, record: JointRecord):
        """Makes the system.

        Args:
            record: the recorded motion of n joints.
        """
        super().__init__()
        self._record = record
        size = len(record.names)
        self.DeclareVectorOutputPort(
            name="joint_positions",
            size=size,
            calc=self._CalcPositions,
            prerequisites_of_calc={self.time_ticket()},
        )
        self.DeclareVectorOutputPort(
            name="joint_velocities",
            size=size,
            calc=self._CalcVelocities,
            prerequisites_of_calc={self.time_ticket()},
        )

    def _CalcPositions(self, context: Context, output: BasicVector) -> None:
        q, _ = interpolate_joints(self._record, context.get_time())
        output.SetFromVector(q)

    def _CalcVelocities(self, context: Context, output: BasicVector) -> None:
        _, v = interpolate_joints(self._record, context.get_time())
        output.SetFromVector(v)
