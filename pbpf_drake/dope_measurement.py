"""The value on the filter's ``dope_measurement`` port."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from pydrake.math import RigidTransform


@dataclass(frozen=True)
class Detection:
    """One object as the detector saw it.

    Attributes:
        X_WO: pose of the object in the world; not to be changed.
        time: stamp of the image that it was seen in (in seconds).
    """

    X_WO: RigidTransform
    time: float


@dataclass(frozen=True)
class DopeMeasurement:
    """The latest detection of every object that has been detected so far.

    An object without an entry has never been detected. Consumers tell a new
    detection from an old one by its time stamp. A measurement can't change,
    so a copy of it is itself.

    Attributes:
        detections: by name of the tracked model; copied into a read-only
            mapping.
    """

    detections: Mapping[str, Detection] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Makes ``detections`` read-only."""
        frozen = MappingProxyType(dict(self.detections))
        object.__setattr__(self, "detections", frozen)

    # Drake copies the values of ports, but can't copy a read-only mapping.
    def __deepcopy__(self, memo: dict) -> "DopeMeasurement":
        return self
