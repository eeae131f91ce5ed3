"""The filter outside of any simulation, as on a live robot.

There, a driver reads the robot and a detector reads the camera. The loop that
asks them calls LiveFilter whenever an update is due.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.dope_measurement import DopeMeasurement
from pbpf_drake.filtering.add_particle_filter import MakeParticleFilter
from pbpf_drake.filtering.slow_updates import LateUpdates


@dataclass(frozen=True)
class Reading:
    """What the loop of a live robot has read at one time.

    Attributes:
        time: of a clock that never goes back (in seconds).
        positions: (n,) the robot's measured joints.
        measurement: the latest detections, with stamps of the same clock.
    """

    time: float
    positions: np.ndarray
    measurement: DopeMeasurement


class LiveFilter:
    """A filter outside of any simulation, updated by hand.

    An update that takes longer than the filter's period is late: it is
    counted, and Python's log says so. The loop then waits for NextTime, which
    leaves out the periods that are over. Nothing that the robot did meanwhile
    is lost: an update predicts from the reading of the last update to its
    own. Only the process noise stays that of one update.

    Attributes:
        late_updates: counts the updates that were late.

    Args:
        scene: the robot, the objects and the camera.
        start: what is read before the first update.
        config: of the filter; by default the scene's. ``control_samples``
            doesn't count: the joints are taken to move straight from one
            reading to the next.

    Raises:
        ValueError: a model doesn't fit its role, or a field of the config is
            out of range.
    """

    def __init__(
        self,
        *,
        scene: Scene,
        start: Reading,
        config: ParticleFilterConfig | None = None,
    ) -> None:
        config = replace(config or scene.filter, control_samples=1)
        self.late_updates = LateUpdates(config.period)
        self._filter = MakeParticleFilter(
            scene=scene, config=config, on_update=self.late_updates.AddUpdate
        )
        self._period, self._start = config.period, start.time
        self._context = self._filter.CreateDefaultContext()
        self._Read(start)
        self._filter.ExecuteInitializationEvents(self._context)

    def Update(self, reading: Reading) -> list[RigidTransform]:
        """Makes an update; returns the K poses X_WO, in the scene's order.

        Args:
            reading: later than the last one: by about the filter's period, or
                by more where updates were left out.

        Raises:
            ValueError: the reading isn't later than the last one.
        """
        last = self._context.get_time()
        if not reading.time > last:
            raise ValueError(
                f"the reading's time is {reading.time} s, and the last one's "
                f"was {last} s; expected a clock that never goes back"
            )
        self._Read(reading)
        values = self._filter.EvalUniquePeriodicDiscreteUpdate(self._context)
        self._context.SetDiscreteState(values)
        return self.Output("estimated_poses")

    def Output(self, port: str) -> Any:
        """Returns the value of one of the filter's output ports.

        Args:
            port: such as "covariances"; see PhysicsBasedParticleFilter.

        Raises:
            RuntimeError: there is no such port.
        """
        return self._filter.GetOutputPort(port).Eval(self._context)

    def NextTime(self, now: float) -> float:
        """Returns when the next update is due (in seconds).

        That is the first time after now which is a whole number of periods
        after the start.

        Args:
            now: when the last update was done (in seconds).
        """
        periods = np.floor((now - self._start) / self._period + 1e-9)
        return float(self._start + self._period * (periods + 1))

    def _Read(self, reading: Reading) -> None:
        context, tracker = self._context, self._filter
        context.SetTime(reading.time)
        tracker.GetInputPort("joint_positions").FixValue(
            context, reading.positions
        )
        tracker.GetInputPort("dope_measurement").FixValue(
            context, Value(reading.measurement)
        )
