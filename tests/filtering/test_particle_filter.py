from filter_fixtures import (
    BLOCK,
    PERIOD,
    PROBE,
    FilterRun,
    block_at,
    detections,
    planar_scene,
    probe_at,
    push,
    read_port,
    read_ports,
    small_config,
)
import numpy as np
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from pbpf_drake.config.distributions import PoseStddev, TruncatedGaussian
from pbpf_drake.config.physical_parameters_config import (
    PhysicalParametersConfig,
)
from pbpf_drake.filtering.add_particle_filter import AddParticleFilter

MOTIONS = ("physics", "constant_velocity")
# Nothing is random, and the block stands where it isn't pushed.
ROUGH = {
    "initial_noise": PoseStddev(),
    "process_noise": PoseStddev(),
    "physics": PhysicalParametersConfig(
        friction=TruncatedGaussian(mean=1.0, stddev=0.0, min=0.1)
    ),
}


@pytest.fixture(scope="module")
def scene():
    return planar_scene()


def _make(scene, **changes) -> FilterRun:
    return FilterRun(scene, small_config(scene, **changes))


# Before the first detection.


@pytest.mark.parametrize("motion", MOTIONS)
def test_before_the_first_detection_ports_give_what_is_documented(
    scene, motion
):
    run = _make(scene, motion=motion)
    initial = scene.filter.initial_noise
    for update in (0, 1, 2):
        run.update(update)
        ports = run.ports()
        np.testing.assert_allclose(
            ports["estimated_poses"], [[1, 0, 0, 0, *BLOCK]], atol=1e-15
        )
        np.testing.assert_array_equal(
            ports["particles"].reshape(8, 7), [[1, 0, 0, 0, *BLOCK]] * 8
        )
        np.testing.assert_array_equal(ports["weights"], [1 / 8] * 8)
        assert ports["effective_sample_size"] == pytest.approx([8])
        np.testing.assert_allclose(
            ports["covariances"].reshape(6, 6),
            np.diag(
                [initial.rotation**2 / 3] * 3
                + [initial.position**2 / 2] * 2
                + [0]
            ),
        )
        np.testing.assert_array_equal(ports["tracked"], [0])
        np.testing.assert_array_equal(ports["detected"], [0])
        expected = PERIOD * update if update else -1
        assert ports["update_time"] == pytest.approx([expected])


def test_ports_work_without_any_simulation(scene):
    run = _make(scene)
    dut, context = run.filter, run.filter.CreateDefaultContext()
    ports = read_ports(dut, context)
    np.testing.assert_array_equal(ports["estimated_poses"][0, 4:], BLOCK)
    np.testing.assert_array_equal(ports["update_time"], [-1])


def test_velocities_and_detections_need_not_be_connected(scene):
    run = _make(scene)
    assert not run.filter.GetInputPort("dope_measurement").HasValue(run.context)
    assert not run.filter.GetInputPort("joint_velocities").HasValue(run.context)
    run.update(1)
    assert run["update_time"] == pytest.approx([PERIOD])


def test_no_output_has_direct_feedthrough(scene):
    dut = _make(scene).filter
    assert not dut.HasAnyDirectFeedthrough()


# The first detection and after.


def test_after_a_detection_the_object_is_tracked_for_good(scene):
    run = _make(scene)
    run.measure(detections(0.1, block=BLOCK))
    for update, detected in ((1, 1), (2, 0), (3, 0)):
        run.update(update)
        np.testing.assert_array_equal(run["tracked"], [1])
        np.testing.assert_array_equal(run["detected"], [detected])


def test_estimate_and_covariance_are_those_of_the_weighted_particles(scene):
    run = _make(scene, num_particles=40)
    push(run, range(1, 4))
    assert run["effective_sample_size"] < 39
    weights = run["weights"]
    p = run["particles"].reshape(40, 7)[:, 4:]
    mean = weights @ p
    np.testing.assert_allclose(run["estimated_poses"][0, 4:], mean)
    np.testing.assert_allclose(
        run["covariances"].reshape(6, 6)[3:, 3:],
        np.einsum("m,mi,mj->ij", weights, p - mean, p - mean),
        atol=1e-12,
    )
    assert run["effective_sample_size"] == pytest.approx([1 / sum(weights**2)])
    assert np.sum(weights) == pytest.approx(1)


def test_a_pushed_block_is_followed_while_it_is_hidden(scene):
    run = _make(
        scene,
        initial_noise=PoseStddev(),
        process_noise=PoseStddev(position=0.001, rotation=0.005),
    )
    run.measure(detections(0.1, block=block_at(0)))
    # Nothing is detected from now on.
    run.move_joints(lambda t: [PROBE[0] + 0.1 * t, 0.0], 11)
    moved = run["estimated_poses"][0, 4] - block_at(0)[0]
    assert moved == pytest.approx(0.1 * 11 * PERIOD, abs=0.005)
    assert run["detected"] == [0]


def test_what_the_robot_did_within_a_period_counts(scene):
    """The probe pushes the block, and is back when the period ends."""
    ends = []
    for excursion in (0.0, 0.01):
        run = _make(scene, **ROUGH)
        run.measure(detections(0.15, block=block_at(0)))

        def path(t, excursion=excursion):
            # There and back between the first and the second update.
            share = np.clip(t / PERIOD - 1, 0, 1)
            return [PROBE[0] + excursion * np.sin(np.pi * share), 0.0]

        run.move_joints(path, 2)
        ends.append(run["estimated_poses"][0, 4])
    assert ends[1] - ends[0] == pytest.approx(0.01, abs=0.004)


def test_velocities_bend_the_path_between_two_samples(scene):
    ends = []
    for v in (0.0, 0.5):
        run = _make(scene, control_samples=1, **ROUGH)
        port = run.filter.GetInputPort("joint_velocities")
        port.FixValue(run.context, [v, 0.0])
        run.measure(detections(0.15, block=block_at(0)))
        run.update(1)
        port.FixValue(run.context, [-v, 0.0])
        run.update(2)
        ends.append(run["estimated_poses"][0, 4])
    # Forwards and back: by v T / 4.
    assert ends[1] - ends[0] == pytest.approx(0.5 * PERIOD / 4, abs=5e-3)


# By hand.


@pytest.mark.parametrize("motion", MOTIONS)
def test_updates_can_be_made_by_hand(scene, motion):
    run = _make(scene, motion=motion, control_samples=1)
    dut, context = run.filter, run.filter.CreateDefaultContext()
    dut.GetInputPort("joint_positions").FixValue(context, PROBE)
    dut.ExecuteInitializationEvents(context)
    for i in range(1, 4):
        measurement = detections(PERIOD * i - 0.02, block=block_at(i))
        run.set_joints(probe_at(i))
        run.measure(measurement)
        run.update(i)
        context.SetTime(PERIOD * i)
        dut.GetInputPort("joint_positions").FixValue(context, probe_at(i))
        dut.GetInputPort("dope_measurement").FixValue(
            context, Value(measurement)
        )
        values = dut.AllocateDiscreteVariables()
        dut.CalcForcedDiscreteVariableUpdate(context, values)
        context.SetDiscreteState(values)
    by_hand, simulated = read_ports(dut, context), run.ports()
    # Times differ in the last bits: those of a simulator are sums.
    for name, value in simulated.items():
        np.testing.assert_allclose(by_hand[name], value, atol=1e-6)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("time", [0.0, 0.3])
def test_an_update_by_hand_needs_no_initialization(scene, motion, time):
    """The robot is taken to be where it is; no time has passed."""
    run = _make(scene, motion=motion)
    dut, context = run.filter, run.filter.CreateDefaultContext()
    context.SetTime(time)
    dut.GetInputPort("joint_positions").FixValue(context, PROBE)
    dut.GetInputPort("dope_measurement").FixValue(
        context, Value(detections(time, block=BLOCK))
    )
    for _ in range(2):
        values = dut.AllocateDiscreteVariables()
        dut.CalcForcedDiscreteVariableUpdate(context, values)
        context.SetDiscreteState(values)
    assert read_port(dut, context, "update_time") == [time]
    np.testing.assert_array_equal(read_port(dut, context, "tracked"), [1])
    poses = read_port(dut, context, "estimated_poses")
    np.testing.assert_allclose(poses[0, 4:6], BLOCK[:2], atol=0.03)


def test_one_control_sample_is_one_periodic_update(scene):
    run = _make(scene, control_samples=1)
    run.measure(detections(PERIOD, block=BLOCK))
    run.update(0)
    run.context.SetTime(PERIOD)
    values = run.filter.EvalUniquePeriodicDiscreteUpdate(run.context)
    run.context.SetDiscreteState(values)
    assert run["update_time"] == pytest.approx([PERIOD])
    np.testing.assert_array_equal(run["detected"], [1])


def test_updates_are_reported_with_their_wall_time(scene):
    seconds = []
    builder = DiagramBuilder()
    dut = AddParticleFilter(
        builder=builder,
        scene=scene,
        config=small_config(scene),
        on_update=seconds.append,
    )
    context = dut.CreateDefaultContext()
    dut.GetInputPort("joint_positions").FixValue(context, PROBE)
    Simulator(dut, context).AdvanceTo(3.5 * PERIOD)
    assert len(seconds) == 3
    assert all(0 < s < 10 for s in seconds)
