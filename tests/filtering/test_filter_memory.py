from dataclasses import replace

import numpy as np
from pydrake.systems.framework import LeafSystem
import pytest
from update_fixtures import NOMINAL, make_config

from pbpf_drake.filtering.filter_memory import FilterMemory, history_length


@pytest.mark.parametrize(
    "max_age, period, length",
    [
        pytest.param(0.16, 0.16, 0, id="of this period"),
        pytest.param(0.1, 0.16, 0, id="less"),
        pytest.param(0.17, 0.16, 1, id="a little more"),
        pytest.param(2.0, 0.16, 12, id="two seconds"),
        pytest.param(2.0, 1e-5, 60, id="no more than there is memory for"),
    ],
)
def test_the_past_is_remembered_as_far_as_detections_may_be_old(
    max_age, period, length
):
    config = make_config(max_detection_age=max_age, period=period)
    assert history_length(config) == length


class Keeper(LeafSystem):
    def __init__(self):
        super().__init__()
        self.memory = FilterMemory(
            self.DeclareDiscreteState,
            config=make_config(num_particles=5),
            nominal_poses=NOMINAL,
            num_joints=2,
        )


def test_what_is_written_is_read_again():
    dut = Keeper()
    context = dut.CreateDefaultContext()
    values = context.get_mutable_discrete_state()
    memory = dut.memory
    state = replace(memory.State(context), weights=np.arange(5.0))
    detections = replace(
        memory.Detections(values), detection_stamps=np.array([0.3])
    )
    samples = memory.Samples(values) + 1.0
    memory.WriteState(values, state)
    memory.WriteDetections(values, detections)
    memory.WriteSamples(values, samples)
    memory.WriteUpdateTime(values, 0.48)
    np.testing.assert_array_equal(memory.State(context).weights, np.arange(5.0))
    assert memory.Detections(values).detection_stamps == [0.3]
    np.testing.assert_array_equal(memory.Samples(values), samples)
    assert memory.UpdateTime(values) == 0.48


def test_before_the_first_update_its_time_is_negative():
    dut = Keeper()
    values = dut.CreateDefaultContext().get_discrete_state()
    assert dut.memory.UpdateTime(values) == -1.0
