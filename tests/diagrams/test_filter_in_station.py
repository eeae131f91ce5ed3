"""The filter beside a diagram of somebody's own."""

from dataclasses import replace

from filter_fixtures import (
    PERIOD,
    assert_same,
    make_push_log,
    planar_scene,
    read_ports,
    small_config,
)
import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, Multiplexer
import pytest

from pbpf_drake.diagrams.filter_in_station import (
    DETECTIONS,
    POSITIONS,
    AddFilterToStation,
    MakeStation,
    TrackByHand,
    TrackInSimulation,
)
from pbpf_drake.filtering.add_particle_filter import MakeParticleFilter
from pbpf_drake.poses.pose_conversion import pose_array

LOG = make_push_log(duration=1.0)
MIDDLE = 3.5 * PERIOD


@pytest.fixture(scope="module")
def scene():
    scene = planar_scene()
    return replace(scene, filter=small_config(scene, seed=3))


class _World:
    """A station with filters beside it."""

    def __init__(self, scene, *names):
        self.builder = DiagramBuilder()
        # A station without a name: it isn't needed.
        self.station = self.builder.AddSystem(MakeStation(scene, LOG))
        self.filters = [
            AddFilterToStation(
                builder=self.builder,
                station=self.station,
                scene=scene,
                name=name,
            )
            for name in names
        ]

    def ports(self, context, which: int = 0):
        dut = self.filters[which]
        return read_ports(dut, dut.GetMyContextFromRoot(context))


def _simulate(scene, *names):
    world = _World(scene, *names)
    simulator = Simulator(world.builder.Build())
    simulator.AdvanceTo(MIDDLE)
    return world, simulator


def test_only_the_stations_ports_are_known(scene):
    station = MakeStation(scene, LOG)
    names = [
        station.get_output_port(i).get_name()
        for i in range(station.num_output_ports())
    ]
    assert names == [POSITIONS, DETECTIONS]
    assert station.num_input_ports() == 0


def test_the_filter_finds_the_object_through_the_stations_ports(scene):
    world, simulator = _simulate(scene, "any")
    ports = world.ports(simulator.get_context())
    assert ports["tracked"] == [1]
    assert ports["update_time"] == pytest.approx([3 * PERIOD])
    truth = LOG.ground_truth["block"].p_WO[0]
    np.testing.assert_allclose(
        ports["estimated_poses"][0, 4:], truth, atol=0.04
    )


def test_the_names_of_filters_and_their_number_change_nothing(scene):
    world, simulator = _simulate(scene, "one", "an other")
    alone, alone_simulator = _simulate(scene, "particle filter?")
    first, second = (world.ports(simulator.get_context(), i) for i in (0, 1))
    assert_same(first, second)
    assert_same(first, alone.ports(alone_simulator.get_context()))


def test_the_estimate_can_be_fed_back_without_an_algebraic_loop(scene):
    """An output of the filter goes through a gain back to its own input."""
    builder = DiagramBuilder()
    dut = builder.AddSystem(MakeParticleFilter(scene=scene))
    # Two joints, and K = 1: two ports of size 1 make an input.
    back = builder.AddSystem(Multiplexer(2))
    for i, name in enumerate(["effective_sample_size", "tracked"]):
        builder.Connect(dut.GetOutputPort(name), back.get_input_port(i))
    builder.Connect(back.get_output_port(), dut.GetInputPort("joint_positions"))
    diagram = builder.Build()  # Refuses algebraic loops.
    simulator = Simulator(diagram)
    simulator.AdvanceTo(MIDDLE)
    context = dut.GetMyContextFromRoot(simulator.get_context())
    assert dut.GetOutputPort("update_time").Eval(context)[0] > 0


@pytest.mark.parametrize("convert", ["ToAutoDiffXd", "ToSymbolic"])
def test_another_scalar_is_refused_with_the_name_of_the_filter(scene, convert):
    world = _World(scene, "my_tracker")
    diagram = world.builder.Build()
    message = "my_tracker .*does not support scalar conversion"
    with pytest.raises(RuntimeError, match=message):
        getattr(diagram, convert)()
    maybe = getattr(diagram, f"{convert}Maybe")
    assert maybe() is None


def test_the_diagram_can_be_drawn(scene):
    drawing = _World(scene, "my_tracker").builder.Build().GetGraphvizString()
    assert drawing.startswith("digraph")
    for text in "my_tracker", "dope_measurement", "estimated_poses", POSITIONS:
        assert text in drawing


def test_vector_ports_can_be_logged(scene):
    world = _World(scene, "my_tracker")
    names = ["particles", "weights", "covariances", "update_time"]
    sinks = {
        name: LogVectorOutput(
            world.filters[0].GetOutputPort(name),
            world.builder,
            publish_period=PERIOD / 2,
        )
        for name in names
    }
    simulator = Simulator(world.builder.Build())
    simulator.AdvanceTo(3.75 * PERIOD)
    for name, sink in sinks.items():
        log = sink.FindLog(simulator.get_context())
        np.testing.assert_allclose(
            log.sample_times(), PERIOD * np.arange(0, 4, 0.5), atol=1e-9
        )
        last = world.ports(simulator.get_context())[name]
        np.testing.assert_array_equal(log.data()[:, -1], np.ravel(last))
    times = sinks["update_time"].FindLog(simulator.get_context()).data()[0]
    # What is published at an update's time is what was before it.
    np.testing.assert_allclose(
        times, [-1, -1, -1, *PERIOD * np.array([1, 1, 2, 2, 3])]
    )


def test_a_cloned_context_of_the_diagram_goes_on_identically(scene):
    world, simulator = _simulate(scene, "my_tracker")
    clone = simulator.get_context().Clone()
    simulator.AdvanceTo(5.5 * PERIOD)
    other = Simulator(simulator.get_system(), clone)
    other.AdvanceTo(5.5 * PERIOD)
    assert_same(
        world.ports(simulator.get_context()), world.ports(other.get_context())
    )


def test_by_hand_and_in_a_simulation_estimates_are_the_same(scene):
    one = replace(scene, filter=replace(scene.filter, control_samples=1))
    simulated = TrackInSimulation(one, LOG, MIDDLE)
    by_hand = TrackByHand(one, LOG, MIDDLE)
    for a, b in zip(simulated, by_hand, strict=True):
        # Times differ in the last bits: those of a simulator are sums.
        np.testing.assert_allclose(pose_array(a), pose_array(b), atol=1e-6)
