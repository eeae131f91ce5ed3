"""Filters to feed by hand, and small scenes and logs for them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from pbpf_drake.add_particle_filter import MakeParticleFilter
from pbpf_drake.dope_measurement import Detection, DopeMeasurement
from pbpf_drake.log import DetectionRecord, JointRecord, Log, PoseRecord
from pbpf_drake.particle_filter import PhysicsBasedParticleFilter
from pbpf_drake.particle_filter_config import ParticleFilterConfig
from pbpf_drake.pose_conversion import pose_array
from pbpf_drake.scene import LoadScene, Scene
from pbpf_drake.scene_models import data_folder

SCENES = data_folder("diagrams") / "scenes"
PERIOD = 0.16
# Where the block of the planar pushes starts, and the probe.
BLOCK = (0.2, 0.0, 0.0065)
PROBE = (0.15, 0.0)
# Between the axis of the probe and the centre of the block in contact.
REACH = 0.045 + 0.004745

BLOCKS_SCENE = """
directives:
- add_model: {{name: table, file: package://pbpf_drake/table/table.sdf}}
- add_weld: {{parent: world, child: table::table}}
- add_model: {{name: pusher, file: package://pbpf_drake/planar_push/pusher.urdf}}
- add_weld: {{parent: world, child: pusher::pusher_base}}
- add_collision_filter_group:
    name: probe_through_table
    members: [pusher::pusher_probe, table::table]
    ignored_collision_filter_groups: [probe_through_table]
{blocks}
robot: pusher
tracked: {{{names}}}
camera:
  X_WC: {{translation: [0.37, 0.0, 1.0], rotation: !Rpy {{deg: [180, 0, 0]}}}}
"""
_BLOCK = """
- add_model:
    name: {name}
    file: package://pbpf_drake/planar_push/block.sdf
    default_free_body_pose: {{block: {{translation: {position}}}}}
"""


def planar_scene() -> Scene:
    """Returns the scene of the recorded pushes."""
    return LoadScene(SCENES / "planar_push.yaml")


def write_blocks_scene(
    folder: Path,
    positions: Mapping[str, Sequence[float]],
    *,
    more: str = "",
) -> Scene:
    """Returns a scene of the planar pusher and some steel blocks.

    Args:
        folder: where to write its file.
        positions: of the blocks' centres, by name.
        more: further directives.
    """
    blocks = "".join(
        _BLOCK.format(name=name, position=list(p))
        for name, p in positions.items()
    )
    names = ", ".join(f"{name}: {{}}" for name in positions)
    path = folder / "blocks.yaml"
    path.write_text(BLOCKS_SCENE.format(blocks=blocks + more, names=names))
    return LoadScene(path)


def detections(
    time: float, **poses: Sequence[float] | RigidTransform
) -> DopeMeasurement:
    """Returns a measurement of objects at one time.

    Args:
        time: their stamps.
        poses: X_WO by name of the object, or positions of what isn't turned.
    """
    found = {}
    for name, X_WO in poses.items():
        if not isinstance(X_WO, RigidTransform):
            X_WO = RigidTransform(p=X_WO)
        found[name] = Detection(X_WO, time)
    return DopeMeasurement(found)


# By scene and config. Parsing the models takes longer than most tests, and a
# system has no state: that is in its contexts.
_filters: dict[tuple, tuple[Scene, PhysicsBasedParticleFilter]] = {}


def _filter(
    scene: Scene, config: ParticleFilterConfig
) -> PhysicsBasedParticleFilter:
    key = (id(scene), repr(config))
    if key not in _filters:
        made = MakeParticleFilter(scene=scene, config=config)
        _filters[key] = scene, made  # The scene, too, or its id is used again.
    return _filters[key][1]


class FilterRun:
    """A filter in a simulation, whose inputs are set by hand.

    Attributes:
        filter: the system.
        simulator: simulates nothing else.
    """

    def __init__(
        self,
        scene: Scene,
        config: ParticleFilterConfig,
        *,
        joints: Sequence[float] = PROBE,
    ) -> None:
        """Starts the filter; nothing is detected yet."""
        self.filter = _filter(scene, config)
        self.simulator = Simulator(self.filter)
        self.set_joints(joints)

    @property
    def context(self):
        return self.simulator.get_mutable_context()

    def set_joints(self, q: Sequence[float]) -> None:
        port = self.filter.GetInputPort("joint_positions")
        port.FixValue(self.context, np.array(q, dtype=float))

    def move_joints(
        self, path: Callable[[float], Sequence[float]], update: int
    ) -> None:
        """Sets the joints 50 times per second, until ``update``'s end."""
        while self.context.get_time() < (update + 0.5) * PERIOD - 1e-9:
            self.set_joints(path(self.context.get_time()))
            self.simulator.AdvanceTo(self.context.get_time() + PERIOD / 8)

    def measure(self, measurement: object) -> None:
        """Puts anything on the port of the detector."""
        port = self.filter.GetInputPort("dope_measurement")
        port.FixValue(self.context, Value(measurement))

    def update(self, number: int) -> None:
        """Simulates until the middle between two updates."""
        self.simulator.AdvanceTo((number + 0.5) * PERIOD)

    def __getitem__(self, port: str) -> np.ndarray:
        """Returns the value of an output port."""
        return read_port(self.filter, self.context, port)

    def ports(self) -> dict[str, np.ndarray]:
        """Returns the values of all output ports."""
        return read_ports(self.filter, self.context)


def block_at(update: int) -> list[float]:
    """Where a block is that the probe pushes by 0.1 m/s from the start."""
    return [PROBE[0] + REACH + 0.1 * PERIOD * update, 0.0, BLOCK[2]]


def probe_at(update: int) -> tuple[float, float]:
    """Where the probe is that pushes it."""
    return PROBE[0] + 0.1 * PERIOD * update, 0.0


def push(run: FilterRun, updates: range) -> dict[str, np.ndarray]:
    """Pushes the block, which is detected at every other update.

    Returns:
        The values of all output ports at the end.
    """
    for i in updates:
        run.set_joints(probe_at(i))
        if i % 2:
            run.measure(detections(PERIOD * i - 0.02, block=block_at(i)))
        run.update(i)
    return run.ports()


def read_port(dut, context, name: str) -> np.ndarray:
    """Returns the value of an output port; poses as an array (K, 7)."""
    value = dut.GetOutputPort(name).Eval(context)
    if name == "estimated_poses":
        return np.array([pose_array(X_WO) for X_WO in value])
    return np.array(value)


def read_ports(dut, context) -> dict[str, np.ndarray]:
    """Returns the values of all output ports, by name."""
    names = [
        dut.get_output_port(i).get_name() for i in range(dut.num_output_ports())
    ]
    return {name: read_port(dut, context, name) for name in names}


def assert_same(first: Mapping, second: Mapping) -> None:
    """Asserts that all ports are equal to the bit."""
    assert first.keys() == second.keys()
    for name, value in first.items():
        np.testing.assert_array_equal(value, second[name], err_msg=name)


def small_config(scene: Scene, **changes) -> ParticleFilterConfig:
    """Returns the scene's config with few particles, and changes."""
    return replace(scene.filter, **{"num_particles": 8, **changes})


def make_push_log(
    *,
    duration: float = 3.0,
    speed: float = 0.06,
    blackout: tuple[float, float] = (0.5, 0.75),
) -> Log:
    """Returns a straight push through the middle of the block.

    The block stands until the probe is there, and keeps in touch with it: that
    is what friction does at such a speed. Detections have an error of 5 mm,
    come at 15 Hz and are late by 30 ms.

    Args:
        duration: of the log (in seconds).
        speed: of the probe along x (in m/s).
        blackout: shares of the duration, between which nothing is detected.
    """
    times = np.arange(round(100 * duration) + 1) / 100
    probe = np.stack([PROBE[0] + speed * times, 0 * times], axis=1)
    p_WO = np.tile(BLOCK, (len(times), 1))
    p_WO[:, 0] = np.maximum(BLOCK[0], probe[:, 0] + REACH)
    q_WO = np.tile([1.0, 0, 0, 0], (len(times), 1))
    rng = np.random.default_rng(5)
    X_CW = planar_scene().camera.pose().inverse()
    seen = []
    for i in range(0, len(times) - 5, 7):
        error = 0.005 * rng.standard_normal(3)
        if not blackout[0] <= times[i] / duration <= blackout[1]:
            X_WO = RigidTransform(p_WO[i] + error)
            time = times[i]
            seen.append(
                DetectionRecord("block", time, time + 0.03, X_CW @ X_WO)
            )
    return Log(
        joints=JointRecord(("pusher_x", "pusher_y"), times, probe),
        detections=tuple(seen),
        ground_truth={"block": PoseRecord(times, q_WO, p_WO)},
        start_time=1_700_000_000_000_000_000,
    )
