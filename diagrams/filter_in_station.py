"""Adds the filter to a station that is already built, and runs it by hand.

A station is somebody else's diagram: all that is known of it are its exported
ports. The filter is put beside it, and listens to them. No names of systems
matter. On a real robot there is no simulation: a driver reads the robot, a
detector reads the camera, and LiveFilter makes an update whenever one is due.

The station here plays the log that comes with pbpf_drake. main() tracks it in
both ways, which give the same poses.
"""

import sys

from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import LoadScene, Scene
from pbpf_drake.connect_ports import ConnectByName
from pbpf_drake.filtering.add_particle_filter import AddParticleFilter
from pbpf_drake.filtering.live_filter import LiveFilter, Reading
from pbpf_drake.filtering.particle_filter import PhysicsBasedParticleFilter
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import Log
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.tracking.add_log_sources import AddLogSources

# The ports of the station.
POSITIONS = "panda.position_measured"
DETECTIONS = "camera.detections"


def MakeStation(scene: Scene, log: Log) -> Diagram:
    """Returns a station of which only its two ports are known."""
    builder = DiagramBuilder()
    sources = AddLogSources(builder=builder, scene=scene, log=log)
    builder.ExportOutput(sources["joint_positions"], POSITIONS)
    builder.ExportOutput(sources["dope_measurement"], DETECTIONS)
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
    sources = {
        "joint_positions": station.GetOutputPort(POSITIONS),
        "dope_measurement": station.GetOutputPort(DETECTIONS),
    }
    ConnectByName(builder=builder, sources=sources, target=tracker)
    return tracker


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
