import copy

from pydrake.common.value import Value
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.dope_measurement import Detection, DopeMeasurement


def _measurement():
    return DopeMeasurement({"box": Detection(RigidTransform(), 1.5)})


def test_default_has_no_detection():
    assert dict(DopeMeasurement().detections) == {}


def test_it_can_not_be_changed():
    source = {"box": Detection(RigidTransform(), 1.5)}
    measurement = DopeMeasurement(source)
    source["can"] = Detection(RigidTransform(), 2.0)
    assert list(measurement.detections) == ["box"]
    with pytest.raises(TypeError):
        measurement.detections["can"] = source["can"]
    with pytest.raises(AttributeError):
        measurement.detections = source


def test_it_can_be_copied_and_held_by_a_drake_value():
    measurement = _measurement()
    assert copy.deepcopy(measurement) is measurement
    value = Value(measurement).Clone().get_value()
    assert value.detections["box"].time == 1.5
