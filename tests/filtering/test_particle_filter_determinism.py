"""Equal seeds and inputs give equal bits, whatever else happens."""

from filter_fixtures import (
    PERIOD,
    FilterRun,
    assert_same,
    block_at,
    detections,
    planar_scene,
    probe_at,
    push,
    read_ports,
    small_config,
)
import numpy as np
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from pbpf_drake.config.adaptive_count_config import AdaptiveCountConfig
from pbpf_drake.filtering.add_particle_filter import AddParticleFilter

PORTS = ("joint_positions", "dope_measurement")
MOTIONS = ("physics", "constant_velocity")
# From one particle to all that there are.
ADAPTIVE = AdaptiveCountConfig(
    to_belief=True, min_particles=1, bin_position=0.1, bin_rotation=1.0
)
COUNTS = (AdaptiveCountConfig(), ADAPTIVE)


@pytest.fixture(scope="module")
def scene():
    return planar_scene()


def _make(scene, **changes) -> FilterRun:
    return FilterRun(scene, small_config(scene, **changes))


@pytest.mark.parametrize("motion", MOTIONS)
def test_the_same_seed_gives_the_same_bits_and_another_does_not(scene, motion):
    first, again = (
        push(_make(scene, motion=motion), range(1, 5)) for _ in range(2)
    )
    assert_same(first, again)
    other = push(_make(scene, motion=motion, seed=1), range(1, 5))
    assert np.all(other["estimated_poses"] != first["estimated_poses"])


@pytest.mark.parametrize("count", COUNTS, ids=["all", "adaptive"])
def test_one_and_two_threads_agree_to_the_bit(scene, count):
    first, second = (
        push(_make(scene, parallelism=n, adaptive_count=count), range(1, 5))
        for n in (1, 2)
    )
    assert_same(first, second)
    assert (first["particles_used"] < 8) == count.to_belief


def _continue(run: FilterRun, simulator: Simulator) -> dict[str, np.ndarray]:
    """Goes on for two updates with another simulator's context."""
    context = simulator.get_mutable_context()
    joints, dope = (run.filter.GetInputPort(name) for name in PORTS)
    for i in (4, 5):
        joints.FixValue(context, probe_at(i))
        measurement = detections(PERIOD * i - 0.02, block=block_at(i))
        dope.FixValue(context, Value(measurement))
        simulator.AdvanceTo((i + 0.5) * PERIOD)
    return read_ports(run.filter, context)


@pytest.mark.parametrize("count", COUNTS, ids=["all", "adaptive"])
@pytest.mark.parametrize("motion", MOTIONS)
def test_a_context_cloned_between_updates_continues_identically(
    scene, motion, count
):
    run = _make(scene, motion=motion, adaptive_count=count)
    # Other than the joints were at the last update, and since.
    push(run, range(1, 4))
    run.set_joints([probe_at(3)[0] + 0.01, 0.003])
    run.simulator.AdvanceTo(3.7 * PERIOD)
    clones = [run.context.Clone() for _ in range(2)]
    expected = _continue(run, run.simulator)
    # A new simulator initializes, which must not forget what has been.
    actual = _continue(run, Simulator(run.filter, clones[0]))
    assert_same(expected, actual)
    # Nor does it matter what else the filter has computed by now.
    assert_same(expected, _continue(run, Simulator(run.filter, clones[1])))


def test_a_context_whose_time_is_set_back_starts_with_new_samples(scene):
    run = _make(scene)
    push(run, range(1, 4))
    run.context.SetTime(0.0)
    run.simulator.Initialize()
    assert run["update_time"] == [-1]
    run.update(1)
    assert run["update_time"] == pytest.approx([PERIOD])
    assert np.all(np.isfinite(run["particles"]))


def test_two_filters_in_one_diagram_give_what_each_gives_alone(scene):
    configs = {
        "few": small_config(scene, num_particles=4, seed=2),
        "more": small_config(
            scene, num_particles=7, seed=3, use_visibility=True
        ),
    }
    builder = DiagramBuilder()
    for name, config in configs.items():
        dut = AddParticleFilter(
            builder=builder, scene=scene, config=config, name=name
        )
        for port in PORTS:
            if name == "few":
                builder.ExportInput(dut.GetInputPort(port), port)
            else:
                builder.ConnectInput(port, dut.GetInputPort(port))
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    joints, dope = (diagram.GetInputPort(name) for name in PORTS)
    for i in range(1, 5):
        joints.FixValue(context, probe_at(i))
        measurement = detections(PERIOD * i - 0.02, block=block_at(i))
        dope.FixValue(context, Value(measurement))
        simulator.AdvanceTo((i + 0.5) * PERIOD)
    for name, config in configs.items():
        dut = diagram.GetSubsystemByName(name)
        together = read_ports(dut, dut.GetMyContextFromRoot(context))
        run = FilterRun(scene, config)
        for i in range(1, 5):
            run.set_joints(probe_at(i))
            run.measure(detections(PERIOD * i - 0.02, block=block_at(i)))
            run.update(i)
        assert_same(run.ports(), together)
