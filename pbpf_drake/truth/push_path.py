"""From the path of an end effector in the world to the joints' motion."""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, JointIndex, ModelInstanceIndex
from pydrake.solvers import Solve
from pydrake.systems.framework import Context
from pydrake.trajectories import PiecewisePolynomial

from pbpf_drake.config.path_config import PathConfig

# How far off its path an end effector may be, along each axis (in meters).
_TOLERANCE = 2e-5
# How far apart the postures are that are solved for (in seconds).
_SAMPLE_PERIOD = 0.1
# If a joint moves by more than this from one posture to the next (in radians or
# meters), that is no motion, but a jump to another solution of the inverse
# kinematics.
_MAX_STEP = 0.3


def ActuatedJoints(
    plant: MultibodyPlant, robot: ModelInstanceIndex
) -> list[JointIndex]:
    """Returns the robot's joints in the order of its actuators.

    Raises:
        ValueError: a joint that can move has no actuator.
    """
    actuated = [
        plant.get_joint_actuator(i).joint().index()
        for i in plant.GetJointActuatorIndices()
        if plant.get_joint_actuator(i).model_instance() == robot
    ]
    for i in plant.GetJointIndices(robot):
        joint = plant.get_joint(i)
        if joint.num_positions() > 0 and i not in actuated:
            raise ValueError(
                f"joint {joint.name()!r} of the robot has no actuator; "
                "expected one for every joint, to control it"
            )
    return actuated


def AddMissingActuators(
    plant: MultibodyPlant, robot: ModelInstanceIndex
) -> None:
    """Adds an actuator to every joint of the robot that can move but has none.

    URDF files for ROS 2 often leave them out. Those that are added come after
    the file's own, in the order of the joints.

    Args:
        plant: not finalized yet.
        robot: the robot's model instance.
    """
    actuated = {
        plant.get_joint_actuator(i).joint().index()
        for i in plant.GetJointActuatorIndices()
    }
    for index in plant.GetJointIndices(robot):
        joint = plant.get_joint(index)
        if joint.num_velocities() == 1 and index not in actuated:
            plant.AddJointActuator(f"{joint.name()}_added", joint)


def draw_offsets(config: PathConfig, rng: np.random.Generator) -> np.ndarray:
    """Draws how far a run's waypoints are off the configured ones.

    Args:
        config: has W waypoints.
        rng: where the random numbers come from, two for each waypoint.

    Returns:
        (W, 3) in the axes of the world (in meters). The first waypoint is never
        off. One that repeats the waypoint before it is off by as much as that.
    """
    draws = rng.standard_normal((len(config.waypoints), 2)) * config.stddev
    offsets = np.zeros((len(config.waypoints), 3))
    for i in range(1, len(offsets)):
        before, here = config.waypoints[i - 1 : i + 1]
        if here.translation == before.translation:
            offsets[i] = offsets[i - 1]
        else:
            offsets[i, :2] = draws[i]
    return offsets


def MakeTranslation(
    config: PathConfig, offsets: np.ndarray
) -> PiecewisePolynomial:
    """Returns how far the end effector has moved from its start, over time.

    Args:
        config: has W waypoints.
        offsets: (W, 3) what is added to them (in meters).

    Returns:
        p(t), 3 x 1, in the axes of the world (in meters): a piecewise cubic
        that doesn't overshoot its waypoints and is at rest at both ends.
    """
    times = [w.time for w in config.waypoints]
    values = np.array([w.translation for w in config.waypoints]) + offsets
    if len(times) == 2:
        return PiecewisePolynomial.CubicHermite(
            times, values.T, np.zeros((3, 2))
        )
    return PiecewisePolynomial.CubicShapePreserving(
        times, values.T, zero_end_point_derivatives=True
    )


def MakeJointTrajectory(
    *,
    plant: MultibodyPlant,
    robot: ModelInstanceIndex,
    end_effector: str,
    translation: PiecewisePolynomial,
) -> PiecewisePolynomial:
    """Solves the inverse kinematics along a path with a fixed orientation.

    Args:
        plant: finalized; the robot starts at its default positions.
        robot: the robot's model instance.
        end_effector: the frame of the robot that follows the path.
        translation: p(t), how far ``end_effector`` has moved from its start (in
            meters).

    Returns:
        q(t) of the robot's joints, in the order of its actuators (in radians
        or meters), twice differentiable, at rest at both ends.

    Raises:
        ValueError: there is no such frame, or the robot can't reach.
    """
    joints = ActuatedJoints(plant, robot)
    if not plant.HasFrameNamed(end_effector, robot):
        raise ValueError(
            f"recording.path.end_effector is {end_effector!r}; expected the "
            "name of a frame of the robot"
        )
    frame = plant.GetFrameByName(end_effector, robot)
    context = plant.CreateDefaultContext()
    X_WE0 = frame.CalcPoseInWorld(context)
    start, end = translation.start_time(), translation.end_time()
    num_samples = 2 + int((end - start) / _SAMPLE_PERIOD)
    times = np.linspace(start, end, num_samples)
    rows = [plant.get_joint(j).position_start() for j in joints]
    postures = [plant.GetPositions(context)]
    for time in times:
        X_WE = RigidTransform(translation.value(time)) @ X_WE0
        postures.append(_solve(plant, context, rows, frame, X_WE, time))
    q = np.array(postures[1:])[:, rows].T
    at_rest = np.zeros(len(rows))
    return PiecewisePolynomial.CubicWithContinuousSecondDerivatives(
        times, q, at_rest, at_rest
    )


def _solve(
    plant: MultibodyPlant,
    context: Context,
    rows: list[int],
    frame: Frame,
    X_WE: RigidTransform,
    time: float,
) -> np.ndarray:
    """Finds the posture nearest to the context's, and writes it there.

    Returns:
        All positions of the plant.
    """
    start = plant.GetPositions(context)
    ik = InverseKinematics(plant, context)
    program, q = ik.prog(), ik.q()
    others = np.setdiff1d(np.arange(len(start)), rows)
    program.AddBoundingBoxConstraint(start[others], start[others], q[others])
    # The frame's origin and a point on each of its axes keep its orientation:
    # bounds on points are better conditioned than one on an angle of zero.
    for p_EQ in (*(0.1 * np.eye(3)), np.zeros(3)):
        p_WQ = X_WE @ p_EQ
        ik.AddPositionConstraint(
            frameB=frame,
            p_BQ=p_EQ,
            frameA=plant.world_frame(),
            p_AQ_lower=p_WQ - _TOLERANCE,
            p_AQ_upper=p_WQ + _TOLERANCE,
        )
    program.AddQuadraticErrorCost(np.eye(len(rows)), start[rows], q[rows])
    program.SetInitialGuess(q, start)
    result = Solve(program)
    solution = result.GetSolution(q)
    jump = np.max(np.abs(solution - start)[rows])
    if not result.is_success() or jump > _MAX_STEP:
        raise ValueError(
            f"recording.path at {time:.2f} s: {frame.name()!r} can't be at "
            f"{X_WE.translation().round(4).tolist()} with its orientation "
            "kept, within the joints' limits and without a jump"
        )
    plant.SetPositions(context, solution)
    return solution
