"""The estimators of all methods in a diagram."""

from dataclasses import replace

from filter_fixtures import PERIOD, planar_scene, small_config
import numpy as np
from pydrake.common.value import Value
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
import pytest

from pbpf_drake.config.particle_filter_config import METHODS
from pbpf_drake.dope_measurement import DopeMeasurement
from pbpf_drake.filtering.add_estimator import AddEstimator
from pbpf_drake.filtering.particle_filter import PhysicsBasedParticleFilter
from pbpf_drake.filtering.single_snapshot_estimator import (
    SingleSnapshotEstimator,
)


@pytest.mark.parametrize("method", METHODS)
def test_each_method_has_its_estimator_which_updates_every_period(method):
    scene, seconds = planar_scene(), []
    config = replace(small_config(scene), period=PERIOD / 2)
    builder = DiagramBuilder()
    dut = AddEstimator(
        builder=builder,
        scene=scene,
        method=method,
        config=config,
        on_update=seconds.append,
    )
    is_filter = method != "dope"
    kind = PhysicsBasedParticleFilter if is_filter else SingleSnapshotEstimator
    assert isinstance(dut, kind)
    simulator = Simulator(builder.Build())
    context = dut.GetMyContextFromRoot(simulator.get_mutable_context())
    dut.GetInputPort("dope_measurement").FixValue(
        context, Value(DopeMeasurement())
    )
    if is_filter:
        dut.GetInputPort("joint_positions").FixValue(context, np.zeros(2))
    simulator.AdvanceTo(3.25 * PERIOD)
    assert len(seconds) == 6


def test_a_config_that_can_not_be_used_is_refused():
    scene = planar_scene()
    config = replace(small_config(scene), num_particles=0)
    with pytest.raises(ValueError, match="num_particles"):
        AddEstimator(
            builder=DiagramBuilder(), scene=scene, method="pbpf", config=config
        )
