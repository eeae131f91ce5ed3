"""What is known of a scene's models when a log is read."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class MimicJoint:
    """A joint that follows another one: q = multiplier q_leader + offset.

    Attributes:
        leader: name of the joint that it follows.
        multiplier: how far it moves when the leader moves by 1.
        offset: where it is when the leader is at 0 (in radians or meters).
    """

    leader: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class ModelFacts:
    """What a log can be completed with and compared to.

    Attributes:
        mimics: the robot's mimic joints, by their names.
        nominal: (3,) positions in the world that the scene gives the objects,
            by their names (in meters).
        boxes: (B, 2, 3) lowest and highest corners, along the world's axes, of
            all that is known in the scene (in meters).
    """

    mimics: Mapping[str, MimicJoint] = field(default_factory=dict)
    nominal: Mapping[str, np.ndarray] = field(default_factory=dict)
    boxes: np.ndarray = field(default_factory=lambda: np.empty((0, 2, 3)))
