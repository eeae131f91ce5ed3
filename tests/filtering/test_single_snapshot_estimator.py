import numpy as np
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from pbpf_drake.dope_measurement import Detection, DopeMeasurement
from pbpf_drake.filtering.single_snapshot_estimator import (
    SingleSnapshotEstimator,
)

NOMINAL = np.array([[1, 0, 0, 0, 0.1, 0.2, 0.3], [0, 1, 0, 0, 0.4, 0.5, 0.6]])
PERIOD = 0.16
X1 = RigidTransform(RollPitchYaw(0.1, -0.4, 2.0), [0.7, -0.1, 0.05])
X2 = RigidTransform(RollPitchYaw(1.0, 0.2, -3.0), [0.5, 0.3, 0.15])


def _make(**kwargs):
    return SingleSnapshotEstimator(
        object_names=["box", "can"],
        nominal_poses=NOMINAL,
        period=PERIOD,
        **kwargs,
    )


def _run(measurements, **kwargs):
    """Gives one measurement per update and returns dut and context."""
    dut = _make(**kwargs)
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    for i, detections in enumerate(measurements):
        measurement = DopeMeasurement(detections)
        dut.GetInputPort("dope_measurement").FixValue(
            context, Value(measurement)
        )
        simulator.AdvanceTo((i + 1.5) * PERIOD)
    return dut, context


def _eval(dut, context, name):
    return dut.GetOutputPort(name).Eval(context)


def _assert_near(X, X_expected):
    assert X.IsNearlyEqualTo(X_expected, 1e-14)


def test_before_the_first_detection_poses_are_nominal():
    dut, context = _run([{}, {}])
    for X, nominal in zip(
        _eval(dut, context, "estimated_poses"), NOMINAL, strict=True
    ):
        np.testing.assert_array_equal(X.translation(), nominal[4:])
        q = X.rotation().ToQuaternion().wxyz()
        np.testing.assert_array_equal(q, nominal[:4])
    np.testing.assert_array_equal(_eval(dut, context, "tracked"), [0, 0])
    np.testing.assert_array_equal(_eval(dut, context, "detected"), [0, 0])


def test_estimate_is_the_latest_detection():
    dut, context = _run(
        [{"can": Detection(X1, 0.1)}, {"can": Detection(X2, 0.2)}]
    )
    box, can = _eval(dut, context, "estimated_poses")
    _assert_near(can, X2)
    np.testing.assert_array_equal(box.translation(), NOMINAL[0, 4:])
    np.testing.assert_array_equal(_eval(dut, context, "tracked"), [0, 1])
    np.testing.assert_array_equal(_eval(dut, context, "detected"), [0, 1])


@pytest.mark.parametrize(
    "later",
    [
        {},
        {"can": Detection(X1, 0.1)},
        {"can": Detection(X2, 0.1)},
        {"can": Detection(X2, 0.05)},
        {"can": Detection(X2, np.nan)},
        {"can": Detection(X2, np.inf)},
        {"can": Detection(RigidTransform(p=[0, np.nan, 0]), 0.2)},
        {"can": Detection(RigidTransform(p=[0, 0, np.inf]), 0.2)},
        {"stranger": Detection(X2, 0.2)},
    ],
)
def test_pose_is_held_without_a_new_usable_detection(later):
    dut, context = _run([{"can": Detection(X1, 0.1)}, later])
    _assert_near(_eval(dut, context, "estimated_poses")[1], X1)
    np.testing.assert_array_equal(_eval(dut, context, "tracked"), [0, 1])
    np.testing.assert_array_equal(_eval(dut, context, "detected"), [0, 0])


def test_an_unusable_detection_does_not_hide_the_next_one():
    never = {"can": Detection(X2, np.inf)}
    dut, context = _run([never, {"can": Detection(X1, 0.2)}])
    _assert_near(_eval(dut, context, "estimated_poses")[1], X1)


def test_estimate_changes_at_updates_only():
    dut = _make()
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("dope_measurement").FixValue(
        context, Value(DopeMeasurement({"box": Detection(X1, 0.0)}))
    )
    simulator.AdvanceTo(0.99 * PERIOD)
    assert _eval(dut, context, "update_time")[0] == -1.0
    assert _eval(dut, context, "tracked")[0] == 0.0
    simulator.AdvanceTo(1.01 * PERIOD)
    assert _eval(dut, context, "update_time")[0] == PERIOD
    _assert_near(_eval(dut, context, "estimated_poses")[0], X1)
    simulator.AdvanceTo(2.5 * PERIOD)
    assert _eval(dut, context, "update_time")[0] == 2 * PERIOD


def test_no_port_has_direct_feedthrough():
    assert not _make().HasAnyDirectFeedthrough()


def test_a_cloned_context_continues_on_its_own():
    dut, context = _run([{"can": Detection(X1, 0.1)}])
    clone = context.Clone()
    dut.GetInputPort("dope_measurement").FixValue(
        context, Value(DopeMeasurement({"can": Detection(X2, 0.3)}))
    )
    for c in (context, clone):
        Simulator(dut, c).AdvanceTo(3 * PERIOD + 0.01)
    _assert_near(_eval(dut, context, "estimated_poses")[1], X2)
    _assert_near(_eval(dut, clone, "estimated_poses")[1], X1)


def test_two_estimators_live_in_one_diagram():
    builder = DiagramBuilder()
    names = []
    for name in ("a", "b"):
        system = builder.AddNamedSystem(name, _make())
        port = system.GetInputPort("dope_measurement")
        names.append(builder.ExportInput(port, name))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    for i, X in zip(names, (X1, X2), strict=True):
        value = DopeMeasurement({"box": Detection(X, 0.0)})
        diagram.get_input_port(i).FixValue(context, Value(value))
    Simulator(diagram, context).AdvanceTo(1.5 * PERIOD)
    for name, X in (("a", X1), ("b", X2)):
        system = diagram.GetSubsystemByName(name)
        own = system.GetMyContextFromRoot(context)
        _assert_near(_eval(system, own, "estimated_poses")[0], X)


def test_each_update_is_timed():
    durations = []
    _run([{}, {}, {}], on_update=durations.append)
    assert len(durations) == 3
    assert all(0 < d < 1 for d in durations)


def test_a_wrong_payload_is_named():
    dut = _make()
    dut.set_name("baseline")
    simulator = Simulator(dut)
    context = simulator.get_mutable_context()
    dut.GetInputPort("dope_measurement").FixValue(context, Value({"box": X1}))
    message = "baseline: dope_measurement is a dict; expected a DopeMeasurement"
    with pytest.raises(TypeError, match=message):
        simulator.AdvanceTo(1.5 * PERIOD)


def test_nominal_poses_of_a_wrong_shape_are_refused():
    with pytest.raises(ValueError, match=r"shape \(2, 7\); expected \(1, 7\)"):
        SingleSnapshotEstimator(object_names=["box"], nominal_poses=NOMINAL)
