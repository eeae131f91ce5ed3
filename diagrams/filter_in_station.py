"""Adds the filter to a station that is already built, and runs it by hand.

A station is somebody else's diagram: all that is known of it are its exported
ports. The filter is put beside it, and listens to them. On a real robot there
is no simulation: a driver reads the robot, a detector reads the camera, and
LiveFilter makes an update whenever it is time. No names of systems matter.

The station here plays the log that comes with pbpf_drake; main() tracks it in
both ways, which give the same.
"""

from dataclasses import dataclass, replace
import sys

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.dope_measurement import DopeMeasurement
from pbpf_drake.filtering.add_particle_filter import (
    AddParticleFilter,
    MakeParticleFilter,
)
from pbpf_drake.filtering.late_updates import LateUpdates
from pbpf_drake.filtering.particle_filter import PhysicsBasedParticleFilter
from pbpf_drake.log.dope_log_source import DopeLogSource
from pbpf_drake.log.joint_log_source import JointLogSource
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder

# The ports of the station.
POSITIONS = "panda.position_measured"
DETECTIONS = "camera.detections"


def MakeStation(scene: Scene, log: Log) -> Diagram:
    """Returns a station of which only its two ports are known."""
    builder = DiagramBuilder()
    joints = builder.AddSystem(JointLogSource(record=log.joints))
    dope = builder.AddSystem(
        DopeLogSource(detections=log.detections, X_WC=scene.camera.pose())
    )
    builder.ExportOutput(joints.GetOutputPort("joint_positions"), POSITIONS)
    builder.ExportOutput(dope.GetOutputPort("dope_measurement"), DETECTIONS)
    return builder.Build()


def AddFilterToStation(
    *,
    builder: DiagramBuilder,
    station: Diagram,
    scene: Scene,
    config: ParticleFilterConfig | None = None,
    name: str = "particle_filter",
) -> PhysicsBasedParticleFilter:
    """Adds a filter that listens to the exported ports of a station.

    Args:
        builder: the station was added to it.
        station: has the two ports; other ports don't matter.
        scene: what is in front of the station's camera.
        config: of the filter; by default the scene's.
        name: of the filter; two filters need two names.
    """
    tracker = AddParticleFilter(
        builder=builder, scene=scene, config=config, name=name
    )
    for port, source in (
        ("joint_positions", POSITIONS),
        ("dope_measurement", DETECTIONS),
    ):
        builder.Connect(
            station.GetOutputPort(source), tracker.GetInputPort(port)
        )
    return tracker


@dataclass(frozen=True)
class Reading:
    """What a live robot loop has at one time.

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
    counted, and told in Python's log. The loop then waits for NextTime, which
    leaves out the periods that are over. Nothing that the robot has done is
    lost: an update predicts from the reading of the last one to its own. The
    process noise is that of one update, though.

    Attributes:
        late_updates: counts them.

    Args:
        scene: the robot, the objects and the camera.
        start: what is read before the first update.
        config: of the filter; by default the scene's. The joints are taken to
            move straight from one reading to the next, ``control_samples``
            doesn't count.
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
            scene=scene, config=config, on_update=self.late_updates.Note
        )
        self._period, self._start = config.period, start.time
        self._context = self._filter.CreateDefaultContext()
        self._Read(start)
        self._filter.ExecuteInitializationEvents(self._context)

    def Update(self, reading: Reading) -> list[RigidTransform]:
        """Returns the poses X_WO by all that was read up to now.

        Args:
            reading: later than the last one, by about the filter's period;
                by more where updates were left out.
        """
        self._Read(reading)
        values = self._filter.EvalUniquePeriodicDiscreteUpdate(self._context)
        self._context.SetDiscreteState(values)
        port = self._filter.GetOutputPort("estimated_poses")
        return port.Eval(self._context)

    def NextTime(self, now: float) -> float:
        """Returns when the next update is due: after the next whole period.

        Args:
            now: when the last update is done (in seconds).
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


class StationDriver:
    """Reads a station's ports, as drivers read a robot."""

    def __init__(self, station: Diagram) -> None:
        self._station = station
        self._context = station.CreateDefaultContext()

    def Read(self, time: float) -> Reading:
        """Returns what the station's ports have at a time (in seconds)."""
        self._context.SetTime(time)
        return Reading(
            time=time,
            positions=self._station.GetOutputPort(POSITIONS).Eval(
                self._context
            ),
            measurement=self._station.GetOutputPort(DETECTIONS).Eval(
                self._context
            ),
        )


def TrackInSimulation(
    scene: Scene, log: Log, duration: float
) -> list[RigidTransform]:
    """Returns the last poses X_WO, by a filter beside a station."""
    builder = DiagramBuilder()
    station = builder.AddSystem(MakeStation(scene, log))
    tracker = AddFilterToStation(builder=builder, station=station, scene=scene)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(duration)
    context = tracker.GetMyContextFromRoot(simulator.get_context())
    return tracker.GetOutputPort("estimated_poses").Eval(context)


def TrackByHand(
    scene: Scene, log: Log, duration: float
) -> list[RigidTransform]:
    """Returns the same, by a loop as that of a live robot."""
    driver = StationDriver(MakeStation(scene, log))
    live = LiveFilter(scene=scene, start=driver.Read(0.0))
    poses: list[RigidTransform] = []
    now = live.NextTime(0.0)
    while now <= duration:
        # A live loop would sleep until then, read its drivers, and after the
        # update its clock.
        poses = live.Update(driver.Read(now))
        now = live.NextTime(now)
    return poses


def main() -> int:
    """Tracks two seconds of the log in both ways; returns the exit code."""
    folder = data_folder("diagrams")
    scene = LoadScene(folder / "scenes" / "cheezit_1.yaml")
    log = ReadLog(
        filename=folder / "logs" / "cheezit_1.mcap",
        scene=scene,
        joint_names=MakePredictionModel(scene).joint_names,
    )
    for track in TrackInSimulation, TrackByHand:
        (X_WO,) = track(scene, log, 2.0)
        print(track.__name__, X_WO.translation().round(4))
    return 0


if __name__ == "__main__":
    sys.exit(main())
