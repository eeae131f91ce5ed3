"""Where to move a fingertip so that it pushes an object to a goal.

It pushes straight on from the side that faces away from the goal: an object
that lies flat against the fingertip comes along with it. A fingertip that
slides along an object turns it. So where to touch is decided before the two
touch, and only corrected a little afterwards. If that isn't enough, the
fingertip goes around the object at a distance until it is behind it again. All
that has to be known of the object is where it is now.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

# Where the fingertip is off the line through goal and object by some angle, its
# direction is off that line by so many times the angle, to the other side:
# before they touch, and afterwards.
_APPROACH_GAIN = 4.0
_PUSH_GAIN = 1.0
# Nearer than this to the object's centre, the fingertip may touch the object
# (in meters).
_NEAR = 0.07
# If it is off that line by more than this, it goes around the object (in
# radians).
_ASIDE = np.pi / 4
# How far from the object's centre the fingertip goes around it (in meters).
_CLEARANCE = 0.085
# If it is nearer to the centre by this much, it moves outwards at 45 degrees
# (in meters); in between, at a smaller angle.
_SLACK = 0.02


def push_direction(
    fingertip: np.ndarray, center: np.ndarray, goal: np.ndarray
) -> np.ndarray:
    """Returns the unit direction (2,) in which to move the fingertip.

    Args:
        fingertip: (2,) where it is (in meters).
        center: (2,) where the object is; neither the goal nor the fingertip.
        goal: (2,) where the object has to go.
    """
    ahead = (goal - center) / np.linalg.norm(goal - center)
    aside = np.array([-ahead[1], ahead[0]])
    offset = fingertip - center
    distance = np.linalg.norm(offset)
    # The angle by which the fingertip is off the point behind the object; it is
    # positive to the left, as seen towards the goal.
    around = np.arctan2(offset @ aside, -(offset @ ahead))
    gain = _APPROACH_GAIN if distance > _NEAR else _PUSH_GAIN
    outwards = np.clip((_CLEARANCE - distance) / _SLACK, -1, 1) * np.pi / 4
    circling = abs(around) + np.pi / 2 + outwards
    angle = min(gain * abs(around), circling)
    if abs(around) > _ASIDE:
        angle = circling
    angle *= -np.sign(around)
    return np.cos(angle) * ahead + np.sin(angle) * aside


@dataclass(frozen=True, kw_only=True)
class PushControllerConfig:
    """How to push.

    Attributes:
        goal: (2,) where the object's centre has to go (in meters).
        height: of the fingertip over the table (in meters).
        speed: of the fingertip (in m/s).
        tolerance: the fingertip rests while the object seems to be this near
            to the goal (in meters).
        lower, upper: (2,) the fingertip stays between them (in meters).
        period: time between two commands (in seconds).
    """

    goal: np.ndarray
    height: float = 0.012
    speed: float = 0.05
    tolerance: float = 0.02
    lower: tuple[float, float] = (0.32, -0.3)
    upper: tuple[float, float] = (0.56, 0.5)
    period: float = 0.02


class PushController(LeafSystem):
    """Pushes an object to a goal by what an estimator says of its pose.

    .. pydrake_system::

        name: PushController
        input_ports:
        - estimated_poses
        output_ports:
        - fingertip_position

    Input ``estimated_poses``: list of RigidTransform X_WO; the first is that
    of the object to push. Output ``fingertip_position``: (3,) where the
    fingertip has to be, in the world (in meters).

    State: the output, which is discrete. Events: an update every ``period``.

    Args:
        config: how to push.
        start: (2,) where the fingertip is at first (in meters).
    """

    def __init__(
        self, *, config: PushControllerConfig, start: np.ndarray
    ) -> None:
        super().__init__()
        self._config = config
        self._poses = self.DeclareAbstractInputPort(
            "estimated_poses", Value([RigidTransform()])
        )
        self._fingertip = self.DeclareDiscreteState([*start, config.height])
        self.DeclareStateOutputPort("fingertip_position", self._fingertip)
        self.DeclarePeriodicDiscreteUpdateEvent(
            period_sec=config.period, offset_sec=0.0, update=self._Update
        )

    def _Update(self, context: Context, values: DiscreteValues) -> None:
        config = self._config
        center = self._poses.Eval(context)[0].translation()[:2]
        if np.linalg.norm(config.goal - center) < config.tolerance:
            return
        fingertip = values.get_mutable_value(self._fingertip)
        step = config.speed * config.period
        direction = push_direction(fingertip[:2], center, config.goal)
        fingertip[:2] = np.clip(
            fingertip[:2] + step * direction, config.lower, config.upper
        )
