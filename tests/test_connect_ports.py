"""Connecting systems by the names of their ports."""

import numpy as np
from pydrake.systems.framework import BasicVector, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource
import pytest

from pbpf_drake.connect_ports import ConnectByName


class _Target(LeafSystem):
    """Has two inputs, and no other."""

    def __init__(self):
        super().__init__()
        for name in "first", "second":
            self.DeclareVectorInputPort(name, BasicVector(1))


def _connect(*names: str):
    """Sources of 0, 1, … are connected to inputs of these names."""
    builder = DiagramBuilder()
    target = builder.AddSystem(_Target())
    sources = {
        name: builder.AddSystem(ConstantVectorSource([i])).get_output_port()
        for i, name in enumerate(names)
    }
    ConnectByName(builder=builder, sources=sources, target=target)
    context = builder.Build().CreateDefaultContext()
    return target, target.GetMyContextFromRoot(context)


def test_each_input_has_the_source_of_its_name():
    target, context = _connect("second", "first")
    for name, value in ("second", 0), ("first", 1):
        np.testing.assert_array_equal(
            target.GetInputPort(name).Eval(context), [value]
        )


@pytest.mark.parametrize("name", ["third", "First"])
def test_what_the_target_has_no_input_for_is_left_out(name):
    target, context = _connect(name, "second")
    assert not target.GetInputPort("first").HasValue(context)
    assert target.GetInputPort("second").Eval(context) == [1]


def test_an_input_without_a_source_stays_free():
    target, context = _connect("first")
    assert target.GetInputPort("first").HasValue(context)
    assert not target.GetInputPort("second").HasValue(context)
