"""A system that plays recorded detections."""

from bisect import bisect_right
from collections.abc import Iterable

from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, LeafSystem

from pbpf_drake.dope_measurement import Detection, DopeMeasurement
from pbpf_drake.log.log_records import DetectionRecord


class DopeLogSource(LeafSystem):
    """Plays recorded detections, each from when it was received.

    .. pydrake_system::

        name: DopeLogSource
        output_ports:
        - dope_measurement

    Output ``dope_measurement``: a DopeMeasurement with poses in the world,
    X_WO = X_WC X_CO. Its entry for an object is, of the detections that were
    received by the context's time, the one with the latest stamp. An object
    that has not been detected yet has no entry.

    The context's time 0 is the log's start.
    """

    def __init__(
        self, *, detections: Iterable[DetectionRecord], X_WC: RigidTransform
    ):
        """Makes the system.

        Args:
            detections: the log's detections in the camera's optical frame C.
            X_WC: pose of the camera in the world.
        """
        super().__init__()
        ordered = sorted(detections, key=lambda d: d.received)
        self._received = [d.received for d in ordered]
        # What is known before the first detection, and after each of them.
        self._measurements = [DopeMeasurement()]
        for detection in ordered:
            known = self._measurements[-1]
            self._measurements.append(_add(known, detection, X_WC))
        self.DeclareAbstractOutputPort(
            name="dope_measurement",
            alloc=lambda: Value(DopeMeasurement()),
            calc=self._CalcMeasurement,
            prerequisites_of_calc={self.time_ticket()},
        )

    def _CalcMeasurement(self, context: Context, output: AbstractValue) -> None:
        count = bisect_right(self._received, context.get_time())
        output.set_value(self._measurements[count])


def _add(
    known: DopeMeasurement, record: DetectionRecord, X_WC: RigidTransform
) -> DopeMeasurement:
    """Returns the measurement after one more detection was received."""
    old = known.detections.get(record.name)
    if old is not None and old.time >= record.time:
        return known
    detection = Detection(X_WC.multiply(record.X_CO), record.time)
    return DopeMeasurement({**known.detections, record.name: detection})
