import numpy as np
from pydrake.common.value import Value
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantValueSource,
    ConstantVectorSource,
)
import pytest
from visual_fixtures import (
    Page,
    has_number,
    has_text,
    write_visual_scene,
)

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.dope_measurement import Detection, DopeMeasurement
from pbpf_drake.filtering.add_particle_filter import AddParticleFilter
from pbpf_drake.filtering.single_snapshot_estimator import (
    SingleSnapshotEstimator,
)
from pbpf_drake.scene.scene_models import data_folder
from pbpf_drake.views.particle_visualizer import (
    AddParticleVisualizer,
    ParticleVisualizer,
)
from pbpf_drake.views.scene_meshcat import SaveReplay

X1 = RigidTransform(RollPitchYaw(0.1, -0.4, 2.0), [0.71, -0.13, 0.057])
X2 = RigidTransform(RollPitchYaw(1.0, 0.2, -3.0), [0.53, 0.31, 0.159])
UNKNOWN = RigidTransform(p=[np.nan, 0.0, 0.0])


@pytest.fixture
def meshcat():
    meshcat = Meshcat()
    yield meshcat
    meshcat.Delete()


@pytest.fixture
def scene(tmp_path):
    return write_visual_scene(tmp_path)


def _show(dut, time=0.001, **inputs):
    """Publishes once with the given inputs; the estimates default to X1."""
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    inputs = {
        "joint_positions": np.zeros(2),
        "estimated_poses": Value([X1, X1]),
        **inputs,
    }
    for name, value in inputs.items():
        dut.GetInputPort(name).FixValue(context, value)
    simulator.AdvanceTo(time)


def _is_visible(page, path):
    (command,) = page.find("set_property", path)
    assert has_text(command, "visible")
    return command.endswith(b"\xc3")


def _is_at(page, path, X):
    (command,) = page.find("set_transform", path)
    numbers = [*X.translation(), *X.rotation().matrix().flat]
    return all(has_number(command, x) for x in numbers)


def test_everything_is_drawn_and_hidden_before_the_first_picture(
    meshcat, scene
):
    ParticleVisualizer(meshcat=meshcat, scene=scene, num_particles=3)
    page = Page(meshcat)
    assert page.find("set_object", "scene/arm/hand/0")
    for name in ("red", "blue"):
        for path in (
            f"estimate/{name}/0",
            f"estimate/{name}/1",
            f"particles/{name}/2/0",
            f"detection/{name}/outline",
            f"detection/{name}/fill/0",
            f"truth/{name}/outline",
            f"truth/{name}/fill/0",
        ):
            assert page.find("set_object", path), path
        # A particle is one shape: the label isn't drawn over and over.
        assert not meshcat.HasPath(f"particles/{name}/2/1")
        assert not meshcat.HasPath(f"particles/{name}/3")
        for kind in ("estimate", "particles", "detection", "truth"):
            assert not _is_visible(page, f"{kind}/{name}")


def test_poses_are_those_of_the_inputs(meshcat, scene):
    dut = ParticleVisualizer(meshcat=meshcat, scene=scene)
    detections = {"blue": Detection(X2, 0.0)}
    _show(
        dut,
        joint_positions=[0.375, 0.0],
        estimated_poses=Value([X1, X2]),
        ground_truth_poses=Value([X2, X1]),
        dope_measurement=Value(DopeMeasurement(detections)),
    )
    page = Page(meshcat)
    hand = RigidTransform([0.0, -0.125, 0.25])
    for path, X in (
        ("estimate/red", X1),
        ("estimate/blue", X2),
        ("truth/red", X2),
        ("truth/blue", X1),
        ("detection/blue", X2),
        ("scene/arm/hand", hand),
    ):
        assert _is_at(page, path, X), path
        if not path.startswith("scene"):
            assert _is_visible(page, path), path


def test_what_is_unknown_is_not_shown(meshcat, scene):
    dut = ParticleVisualizer(meshcat=meshcat, scene=scene)
    detections = {"red": Detection(X1, 0.0)}
    _show(
        dut,
        estimated_poses=Value([X1, UNKNOWN]),
        dope_measurement=Value(DopeMeasurement(detections)),
    )
    page = Page(meshcat)
    assert _is_visible(page, "estimate/red")
    assert not _is_visible(page, "estimate/blue")
    assert _is_visible(page, "detection/red")
    assert not _is_visible(page, "detection/blue")
    assert not _is_visible(page, "truth/red")
    assert not _is_visible(page, "particles/red")


def test_truth_may_be_known_of_some_objects_only(meshcat, scene):
    dut = ParticleVisualizer(
        meshcat=meshcat, scene=scene, ground_truth_names=["blue"]
    )
    _show(dut, ground_truth_poses=Value([X2]))
    page = Page(meshcat)
    assert not _is_visible(page, "truth/red")
    assert _is_visible(page, "truth/blue")
    assert _is_at(page, "truth/blue", X2)


def test_particles_are_unpacked_row_by_row(meshcat, scene):
    dut = ParticleVisualizer(meshcat=meshcat, scene=scene, num_particles=3)
    particles = np.zeros((3, 2, 7))
    particles[..., 0] = 1.0
    particles[..., 4:] = np.arange(18).reshape(3, 2, 3) + 0.5
    _show(dut, particles=particles.ravel())
    page = Page(meshcat)
    for m in range(3):
        for k, name in enumerate(("red", "blue")):
            X = RigidTransform(particles[m, k, 4:])
            path = f"particles/{name}/{m}"
            (command,) = page.find("set_transform", path)
            assert all(has_number(command, x) for x in X.translation())
    assert _is_visible(page, "particles/red")


def test_at_most_70_ghosts_are_drawn_from_the_first_to_the_last(meshcat, scene):
    dut = ParticleVisualizer(meshcat=meshcat, scene=scene, num_particles=1000)
    assert meshcat.HasPath("particles/red/69")
    assert not meshcat.HasPath("particles/red/70")
    particles = np.zeros((1000, 2, 7))
    particles[..., 0] = 1.0
    particles[..., 4] = np.arange(1000)[:, None] + 0.5
    _show(dut, particles=particles.ravel())
    page = Page(meshcat)
    for i, m in ((0, 0), (69, 999)):
        (command,) = page.find("set_transform", f"particles/red/{i}")
        assert has_number(command, m + 0.5)


@pytest.mark.parametrize(("time", "is_new"), [(0.1, True), (0.4, False)])
def test_detection_is_filled_while_it_is_new(meshcat, scene, time, is_new):
    dut = ParticleVisualizer(
        meshcat=meshcat, scene=scene, period=10.0, offset=time
    )
    measurement = DopeMeasurement({"red": Detection(X1, 0.05)})
    _show(dut, time=time + 0.01, dope_measurement=Value(measurement))
    page = Page(meshcat)
    assert _is_visible(page, "detection/red/fill") == is_new
    assert _is_visible(page, "detection/red")


def test_a_wrong_payload_is_named(meshcat, scene):
    dut = ParticleVisualizer(meshcat=meshcat, scene=scene)
    with pytest.raises(TypeError, match="dict; expected a DopeMeasurement"):
        _show(dut, dope_measurement=Value({"red": X1}))


def test_replay_follows_an_estimator_in_a_diagram(meshcat, scene, tmp_path):
    builder = DiagramBuilder()
    estimator = builder.AddSystem(
        SingleSnapshotEstimator(
            object_names=scene.object_names(),
            nominal_poses=np.tile([1.0, 0, 0, 0, 0.901, 0, 0], (2, 1)),
            period=scene.filter.period,
        )
    )
    measurement = DopeMeasurement({"red": Detection(X2, 0.0)})
    dope = builder.AddSystem(ConstantValueSource(Value(measurement)))
    joints = builder.AddSystem(ConstantVectorSource([0.125, 0.0]))
    truth = builder.AddSystem(ConstantValueSource(Value([X1])))
    builder.Connect(dope.get_output_port(), estimator.get_input_port())
    dut = AddParticleVisualizer(
        builder=builder,
        meshcat=meshcat,
        scene=scene,
        filter=estimator,
        joint_positions=joints.get_output_port(),
        dope_measurement=dope.get_output_port(),
        ground_truth_poses=truth.get_output_port(),
        ground_truth_names=["red"],
    )
    assert dut.GetInputPort("particles").size() == 0
    meshcat.StartRecording(set_visualizations_while_recording=False)
    Simulator(builder.Build()).AdvanceTo(0.6)
    SaveReplay(meshcat, tmp_path / "replay.html")
    page = Page(tmp_path / "replay.html")
    (motion,) = page.find("set_animation", "estimate/red")
    for path in ("truth/red", "detection/red"):
        assert has_text(motion, f"/drake/{path}")
    # The nominal pose at first, then the detection; the truth all along.
    for number in (0.901, X2.translation()[1], X1.translation()[2]):
        assert has_number(motion, number)


def test_ghosts_are_the_particles_of_a_filter(meshcat, tmp_path):
    scene = LoadScene(data_folder("diagrams") / "scenes" / "planar_push.yaml")
    config = ParticleFilterConfig(motion="constant_velocity", num_particles=3)
    builder = DiagramBuilder()
    filter = AddParticleFilter(builder=builder, scene=scene, config=config)
    measurement = DopeMeasurement({"block": Detection(X1, 0.1)})
    dope = builder.AddSystem(ConstantValueSource(Value(measurement)))
    joints = builder.AddSystem(ConstantVectorSource([0.1, 0.0]))
    for source in (dope, joints):
        name = "dope_measurement" if source is dope else "joint_positions"
        builder.Connect(source.get_output_port(), filter.GetInputPort(name))
    AddParticleVisualizer(
        builder=builder,
        meshcat=meshcat,
        scene=scene,
        filter=filter,
        joint_positions=joints.get_output_port(),
    )
    meshcat.StartRecording(set_visualizations_while_recording=False)
    simulator = Simulator(builder.Build())
    # The first update is at 0.16 s and drawn a little later.
    simulator.AdvanceTo(0.2)
    context = filter.GetMyContextFromRoot(simulator.get_context())
    particles = filter.GetOutputPort("particles").Eval(context).reshape(3, 7)
    estimate = filter.GetOutputPort("estimated_poses").Eval(context)[0]
    SaveReplay(meshcat, tmp_path / "replay.html")
    page = Page(tmp_path / "replay.html")
    (motion,) = page.find("set_animation", "particles/block/2")
    for p in (*particles[:, 4:], estimate.translation()):
        assert all(has_number(motion, x) for x in p)
