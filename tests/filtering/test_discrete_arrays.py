import numpy as np
from pydrake.systems.framework import LeafSystem

from pbpf_drake.filtering.discrete_arrays import DiscreteArrays

INITIAL = {"table": np.arange(6.0).reshape(2, 3), "number": np.array([7.0])}


class Keeper(LeafSystem):
    def __init__(self):
        super().__init__()
        self.arrays = DiscreteArrays(self.DeclareDiscreteState, INITIAL)


def test_a_default_context_has_the_initial_values_in_their_shapes():
    dut = Keeper()
    values = dut.CreateDefaultContext().get_discrete_state()
    for name, expected in INITIAL.items():
        np.testing.assert_array_equal(
            dut.arrays.Read(values, name), expected, strict=True
        )


def test_each_array_is_a_group_in_the_given_order():
    dut = Keeper()
    state = dut.CreateDefaultContext().get_discrete_state()
    assert state.num_groups() == 2
    assert [int(dut.arrays.index(name)) for name in INITIAL] == [0, 1]


def test_what_is_written_is_read_again():
    dut = Keeper()
    context = dut.CreateDefaultContext()
    values = context.get_mutable_discrete_state()
    dut.arrays.Write(values, "table", 2 * INITIAL["table"])
    np.testing.assert_array_equal(
        dut.arrays.Read(values, "table"), 2 * INITIAL["table"]
    )
    np.testing.assert_array_equal(dut.arrays.Read(values, "number"), [7.0])
