"""The documentation of all systems and public names, against the code."""

from collections.abc import Callable
import importlib
import inspect
from pathlib import Path
import pkgutil
import re

from filter_fixtures import make_push_log, planar_scene, small_config
import numpy as np
from pydrake.geometry import Meshcat
from pydrake.systems.framework import LeafSystem
import pytest
from track_fixtures import make_record
import yaml

import pbpf_drake
from pbpf_drake.config.scene_config import Scene
from pbpf_drake.diagrams.closed_loop.cartesian_servo import CartesianServo
from pbpf_drake.diagrams.closed_loop.push_controller import (
    PushController,
    PushControllerConfig,
)
from pbpf_drake.diagrams.closed_loop.simulated_camera import SimulatedCamera
from pbpf_drake.diagrams.closed_loop.true_pose_source import TruePoseSource
from pbpf_drake.filtering.add_particle_filter import MakeParticleFilter
from pbpf_drake.filtering.particle_filter import PhysicsBasedParticleFilter
from pbpf_drake.filtering.single_snapshot_estimator import (
    SingleSnapshotEstimator,
)
from pbpf_drake.log.dope_log_source import DopeLogSource
from pbpf_drake.log.ground_truth_log_source import GroundTruthLogSource
from pbpf_drake.log.joint_log_source import JointLogSource
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.tracking.track_replay import TrackRecordSource
from pbpf_drake.views.estimate_recorder import EstimateRecorder
from pbpf_drake.views.particle_visualizer import ParticleVisualizer


def _modules() -> list:
    """All modules of the package, in all rooms, and its diagrams."""
    found = pkgutil.walk_packages(pbpf_drake.__path__, "pbpf_drake.")
    return [pbpf_drake, *(importlib.import_module(info.name) for info in found)]


MODULES = _modules()


def _defined(kind: Callable[[object], bool]) -> list:
    """All classes or functions that the package itself defines."""
    return [
        value
        for module in MODULES
        for value in vars(module).values()
        if kind(value) and value.__module__ == module.__name__
    ]


SYSTEMS = [c for c in _defined(inspect.isclass) if issubclass(c, LeafSystem)]
INPUTS_THAT_NEED_NOT_BE_CONNECTED = {
    PhysicsBasedParticleFilter: {"joint_velocities", "dope_measurement"},
    SingleSnapshotEstimator: set(),
    EstimateRecorder: {"covariances", "particles"},
    ParticleVisualizer: {
        "particles",
        "dope_measurement",
        "ground_truth_poses",
    },
}


def _make_servo(scene: Scene) -> CartesianServo:
    model = MakePredictionModel(scene)
    plant, robot = model.diagram.plant(), model.models.robot
    return CartesianServo(
        plant=plant,
        robot=robot,
        hand=plant.GetFrameByName("pusher_probe", robot),
        fingertip=np.zeros(3),
    )


def _make(system: type[LeafSystem], folder: Path) -> LeafSystem:
    """Makes one of every system; a new one needs an entry here."""
    scene, log = planar_scene(), make_push_log(duration=0.5)
    factories: dict[type[LeafSystem], Callable[[], LeafSystem]] = {
        PhysicsBasedParticleFilter: lambda: MakeParticleFilter(
            scene=scene, config=small_config(scene)
        ),
        SingleSnapshotEstimator: lambda: SingleSnapshotEstimator(
            object_names=["block"], nominal_poses=np.ones((1, 7))
        ),
        JointLogSource: lambda: JointLogSource(record=log.joints),
        DopeLogSource: lambda: DopeLogSource(
            detections=log.detections, X_WC=scene.camera.pose()
        ),
        GroundTruthLogSource: lambda: GroundTruthLogSource(
            records=log.ground_truth, object_names=["block"]
        ),
        EstimateRecorder: lambda: EstimateRecorder(
            filename=folder / "estimates.mcap",
            object_names=["block"],
            num_particles=8,
            period=0.16,
        ),
        ParticleVisualizer: lambda: ParticleVisualizer(
            meshcat=Meshcat(), scene=scene, num_particles=8
        ),
        PushController: lambda: PushController(
            config=PushControllerConfig(goal=np.zeros(2)), start=np.ones(2)
        ),
        CartesianServo: lambda: _make_servo(scene),
        SimulatedCamera: lambda: SimulatedCamera(
            scene=scene,
            num_states=MakePredictionModel(scene)
            .diagram.plant()
            .num_multibody_states(),
            rng=np.random.default_rng(0),
        ),
        TrackRecordSource: lambda: TrackRecordSource(
            record=make_record(), nominal_poses=np.ones((1, 7))
        ),
        TruePoseSource: lambda: TruePoseSource(
            plant=MakePredictionModel(scene).diagram.plant(),
            objects=MakePredictionModel(scene).models.objects,
            period=0.16,
        ),
    }
    assert system in factories, f"how to make a {system.__name__}?"
    return factories[system]()


def _block(system: type[LeafSystem]) -> dict:
    """The pydrake_system block, as YAML."""
    doc = inspect.getdoc(system)
    match = re.search(r"\.\. pydrake_system::\n\n((?: {4}.*\n)+)", doc + "\n")
    assert match, f"{system.__name__} has no block .. pydrake_system::"
    return yaml.safe_load(inspect.cleandoc(match.group(1)))


def _documented(block: dict, key: str) -> list[str]:
    return [p.removesuffix(" (optional)") for p in block.get(key, [])]


def test_the_package_has_systems():
    assert len(SYSTEMS) >= 7


@pytest.mark.parametrize("system", SYSTEMS, ids=lambda s: s.__name__)
def test_documented_ports_are_the_real_ones_in_their_order(system, tmp_path):
    dut, block = _make(system, tmp_path), _block(system)
    assert set(block) <= {"name", "input_ports", "output_ports"}
    assert block["name"] == system.__name__
    inputs = [
        dut.get_input_port(i).get_name() for i in range(dut.num_input_ports())
    ]
    outputs = [
        dut.get_output_port(i).get_name() for i in range(dut.num_output_ports())
    ]
    assert _documented(block, "input_ports") == inputs
    assert _documented(block, "output_ports") == outputs
    if isinstance(dut, EstimateRecorder):
        dut.Close()


@pytest.mark.parametrize("system", SYSTEMS, ids=lambda s: s.__name__)
def test_every_port_is_explained(system):
    block, doc = _block(system), inspect.getdoc(system)
    prose = doc[doc.index("pydrake_system") :]
    ports = [*block.get("input_ports", []), *block.get("output_ports", [])]
    for port in ports:
        name = port.removesuffix(" (optional)")
        assert re.search(rf"(Input|Output)s?\b[^.]*``{name}``", prose), (
            f"{system.__name__} says nothing about {name}"
        )


@pytest.mark.parametrize(
    "system, optional",
    INPUTS_THAT_NEED_NOT_BE_CONNECTED.items(),
    ids=lambda s: getattr(s, "__name__", ""),
)
def test_optional_inputs_are_marked(system, optional):
    """Tests of the systems leave them out; here is the list of them."""
    marked = {
        port.removesuffix(" (optional)")
        for port in _block(system)["input_ports"]
        if port.endswith(" (optional)")
    }
    assert marked == optional


@pytest.mark.parametrize("system", SYSTEMS, ids=lambda s: s.__name__)
def test_no_system_has_direct_feedthrough(system, tmp_path):
    dut = _make(system, tmp_path)
    assert not dut.HasAnyDirectFeedthrough()
    if isinstance(dut, EstimateRecorder):
        dut.Close()


def _is_documented(value: object) -> bool:
    """A dataclass without a docstring is given its signature for one."""
    doc, name = value.__doc__, getattr(value, "__name__", "")
    return bool(doc) and not doc.startswith(f"{name}(")


def _undocumented(owner: object, module: str) -> list[str]:
    """Public functions, classes, methods and properties without a text.

    A property may be described among the attributes of its class.
    """
    missing = []
    for name, value in vars(owner).items():
        is_own = getattr(value, "__module__", module) == module
        if name.startswith("_") or not is_own:
            continue
        if inspect.isclass(value):
            missing += [f"{name}.{x}" for x in _undocumented(value, module)]
        if isinstance(value, property):
            attributes = owner.__doc__ or ""
            needs_text = f"\n        {name}: " not in attributes
        else:
            needs_text = inspect.isclass(value) or inspect.isroutine(value)
        if needs_text and not _is_documented(value):
            missing.append(name)
    return missing


@pytest.mark.parametrize("module", MODULES, ids=lambda m: m.__name__)
def test_every_public_name_has_a_docstring(module):
    assert _undocumented(module, module.__name__) == []
    assert _is_documented(module)


def _parameters(function) -> list[inspect.Parameter]:
    return [
        p
        for p in inspect.signature(function).parameters.values()
        if p.name not in ("self", "cls")
    ]


@pytest.mark.parametrize("module", MODULES, ids=lambda m: m.__name__)
def test_arguments_of_public_functions_have_types(module):
    for name, function in vars(module).items():
        if (
            inspect.isfunction(function)
            and function.__module__ == module.__name__
            and not name.startswith("_")
        ):
            for parameter in _parameters(function):
                assert parameter.annotation is not parameter.empty, (
                    name,
                    parameter.name,
                )


def test_arguments_of_systems_are_keywords():
    for system in SYSTEMS:
        kinds = {p.kind for p in _parameters(system.__init__)}
        assert kinds == {inspect.Parameter.KEYWORD_ONLY}, system.__name__


def test_the_package_does_not_import_all_of_drake():
    for module in MODULES:
        source = Path(module.__file__).read_text(encoding="utf-8")
        assert "pydrake.all" not in source, module.__name__
        assert not re.search(r"^\s*from \.", source, re.M), module.__name__
