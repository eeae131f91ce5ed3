import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.framework import DiagramBuilder

from pbpf_drake.log.dope_log_source import DopeLogSource
from pbpf_drake.log.log_records import DetectionRecord

X_WC = RigidTransform(RollPitchYaw(0.1, 2.0, -0.4), [1.0, 2.0, 3.0])


def _pose(x):
    return RigidTransform(RollPitchYaw(x, 0.2, 0.3), [x, 0.5, 1.0])


def _source(*detections):
    return DopeLogSource(
        detections=[DetectionRecord(*d) for d in detections], X_WC=X_WC
    )


def _at(dut, time):
    context = dut.CreateDefaultContext()
    context.SetTime(time)
    return dut.GetOutputPort("dope_measurement").Eval(context).detections


def test_a_detection_is_known_from_when_it_was_received():
    dut = _source(("box", 1.0, 1.2, _pose(0.1)), ("box", 2.0, 2.2, _pose(0.2)))
    assert dict(_at(dut, 1.199)) == {}
    assert _at(dut, 1.2)["box"].time == 1.0
    assert _at(dut, 2.199)["box"].time == 1.0
    assert _at(dut, 2.2)["box"].time == 2.0
    assert _at(dut, 1e9)["box"].time == 2.0


def test_it_is_in_the_world():
    dut = _source(("box", 1.0, 1.0, _pose(0.1)))
    expected = X_WC.GetAsMatrix4() @ _pose(0.1).GetAsMatrix4()
    found = _at(dut, 1.0)["box"].X_WO.GetAsMatrix4()
    np.testing.assert_allclose(found, expected, atol=1e-15)


def test_every_object_has_its_own_latest_detection():
    dut = _source(
        ("box", 1.0, 1.1, _pose(0.1)),
        ("can", 1.5, 1.6, _pose(0.2)),
        ("box", 2.0, 2.1, _pose(0.3)),
    )
    assert set(_at(dut, 1.2)) == {"box"}
    found = _at(dut, 3.0)
    assert (found["box"].time, found["can"].time) == (2.0, 1.5)


def test_a_detection_that_arrives_late_does_not_replace_a_newer_one():
    dut = _source(("box", 1.0, 3.0, _pose(0.1)), ("box", 2.0, 2.1, _pose(0.2)))
    assert _at(dut, 3.5)["box"].time == 2.0


def test_a_log_without_detections_gives_empty_measurements():
    assert dict(_at(_source(), 5.0)) == {}


def test_it_can_be_embedded_and_its_context_cloned():
    dut = _source(("box", 1.0, 1.0, _pose(0.1)))
    builder = DiagramBuilder()
    builder.AddSystem(dut)
    builder.ExportOutput(dut.GetOutputPort("dope_measurement"), "out")
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    context.SetTime(2.0)
    clone = context.Clone()
    for c in (context, clone):
        out = diagram.GetOutputPort("out").Eval(c)
        assert out.detections["box"].time == 1.0
    assert not diagram.HasAnyDirectFeedthrough()
