"""The value on the filter's ``dope_measurement`` port."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, System


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


def EvalDopeMeasurement(system: System, context: Context) -> DopeMeasurement:
    """Returns what a system's input port ``dope_measurement`` holds.

    Args:
        system: the system.
        context: its own, in which the port has a value.

    Raises:
        TypeError: it, or something in it, isn't of the type that it has to be.
    """
    port = f"{system.get_name()}: dope_measurement"
    measurement = system.GetInputPort("dope_measurement").Eval(context)
    _require_type(port, measurement, DopeMeasurement)
    for name, detection in measurement.detections.items():
        _require_type(f"{port}.detections[{name!r}]", detection, Detection)
        path = f"{port}.detections[{name!r}]"
        _require_type(f"{path}.X_WO", detection.X_WO, RigidTransform)
        _require_type(f"{path}.time", detection.time, (int, float))
    return measurement


def _require_type(
    path: str, value: object, expected: type | tuple[type, ...]
) -> None:
    if not isinstance(value, expected):
        kinds = expected if isinstance(expected, tuple) else (expected,)
        raise TypeError(
            f"{path} is a {type(value).__name__}; expected a "
            + " or ".join(kind.__name__ for kind in kinds)
        )
