"""What a message says, in all its forms between the file and the records.

1. A RawMessage is what the file holds. It is decoded.
2. sample_extraction.py makes samples of the decoded message: a JointSample,
   or a PoseSample for each pose in it. A RawStamped holds each of them, with
   the times that the file gives.
3. log_clock.py places them in time: now a Stamped holds each of them.
   log_frames.py changes poses in some frame to poses in the camera or in the
   world.
4. The cleaning modules leave out what can't be used, and make records of the
   rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

# What a message says: a JointSample or a PoseSample.
SampleT = TypeVar("SampleT", covariant=True)


@dataclass(frozen=True)
class JointSample:
    """What a JointState says.

    Attributes:
        names: of m joints.
        positions: as many (in radians or meters), if the message is whole.
        velocities: as many (in rad/s or m/s), or none.
    """

    names: tuple[str, ...]
    positions: Sequence[float]
    velocities: Sequence[float]


@dataclass(frozen=True)
class PoseSample:
    """A pose of something in some frame, as a message says it.

    Attributes:
        frame: what the pose is in; without ROS 1's leading slash.
        name: what it is the pose of: a detector's class name, or a child
            frame. Empty where the message doesn't say.
        q: (4,) quaternion w, x, y, z, of any length.
        p: (3,) position (in meters).
        score: how sure the detector is of it; 0 where it doesn't say.
        is_of_bbox: whether it is the pose of the bounding box, as the message
            has no other one.
    """

    frame: str
    name: str
    q: np.ndarray
    p: np.ndarray
    score: float = 0.0
    is_of_bbox: bool = False


@dataclass(frozen=True)
class RawStamped(Generic[SampleT]):
    """A sample with the times that the file gives.

    Attributes:
        log_time: when its message was recorded (in nanoseconds).
        stamp: the stamp in its header (in nanoseconds); 0 means none.
        value: the sample.
    """

    log_time: int
    stamp: int
    value: SampleT


@dataclass(frozen=True)
class Stamped(Generic[SampleT]):
    """A sample placed in time.

    Attributes:
        time: when it was so (in nanoseconds since the epoch).
        received: when it became known, not before (in nanoseconds).
        value: the sample.
    """

    time: int
    received: int
    value: SampleT
