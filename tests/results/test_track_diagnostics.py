from dataclasses import replace

from filter_fixtures import PERIOD, make_push_log, planar_scene
import numpy as np
import pytest

from pbpf_drake.config.distributions import TruncatedGaussian
from pbpf_drake.config.physical_parameters_config import (
    PhysicalParametersConfig,
)
from pbpf_drake.motion.physics_motion_model import PhysicsMotionModel
from pbpf_drake.results.track_diagnostics import (
    MakeDiagnostics,
    weighted_quantiles,
)
from pbpf_drake.scene.prediction_model import MakePredictionModel
from pbpf_drake.tracking.tracking_diagram import DefaultConfig, Track

LOG = make_push_log(duration=0.8)
SHARES = (0.1, 0.5, 0.9)


@pytest.fixture(scope="module")
def scene():
    return planar_scene()


def _config(scene, method="pbpf"):
    return replace(DefaultConfig(scene, method), num_particles=6)


def _run(scene, method="pbpf", **changes):
    config = replace(_config(scene, method), **changes)
    record = Track(scene=scene, log=LOG, method=method, config=config)
    return record, config


def _diagnose(scene, record, config):
    return MakeDiagnostics(
        scene=scene, joints=LOG.joints, record=record, config=config
    )


def test_quantiles_of_equal_weights_are_those_of_the_values():
    values = np.array([5.0, 1.0, 4.0, 2.0, 3.0])
    actual = weighted_quantiles(values, np.full(5, 0.2), [0.2, 0.5, 1.0])
    np.testing.assert_array_equal(actual, [1.0, 3.0, 5.0])


def test_a_particle_with_all_the_weight_is_every_quantile():
    weights = np.array([0.0, 0.0, 1.0])
    actual = weighted_quantiles(np.array([3.0, 1.0, 2.0]), weights, SHARES)
    np.testing.assert_array_equal(actual, [2.0] * 3)


def test_quantiles_are_those_of_a_sample_with_the_weights_as_counts():
    rng = np.random.default_rng(0)
    values, counts = rng.standard_normal(30), rng.integers(1, 9, 30)
    sample = np.repeat(values, counts)
    expected = np.quantile(sample, SHARES, method="inverted_cdf")
    actual = weighted_quantiles(values, counts / counts.sum(), SHARES)
    np.testing.assert_array_equal(actual, expected)


def test_survivors_have_the_parameters_that_they_were_simulated_with(scene):
    record, config = _run(scene)
    # All weight is on one particle; which θ was it simulated with?
    record.weights[:] = 0.0
    record.weights[:, 2] = 1.0
    model = PhysicsMotionModel(model=MakePredictionModel(scene), config=config)
    diagnostics = _diagnose(scene, record, config)
    for i in range(len(record.times)):
        draw = model.assignment(i + 1)[2]
        for name in "friction", "mass":
            trace = getattr(diagnostics, name)
            expected = getattr(model.parameters(), name)[draw, 0]
            np.testing.assert_array_equal(trace.survivors[i, 0], [expected] * 3)


def test_a_parameter_that_is_known_stays_what_it_is(scene):
    known = TruncatedGaussian(mean=0.7, stddev=0.0, min=0.1)
    physics = PhysicalParametersConfig(mass=known)
    record, config = _run(scene, physics=physics)
    trace = _diagnose(scene, record, config).mass
    np.testing.assert_allclose(trace.survivors, 0.7)
    np.testing.assert_allclose(trace.drawn, 0.7)


@pytest.mark.parametrize("method", ["cvpf", "dope"])
def test_without_physics_there_is_no_theta(scene, method):
    config = _config(scene, method)
    record = Track(scene=scene, log=LOG, method=method, config=config)
    diagnostics = _diagnose(scene, record, config)
    assert diagnostics.friction is None
    assert diagnostics.mass is None
    assert diagnostics.visibility.shape == record.tracked.shape


def test_what_is_in_sight_is_visible_and_what_is_outside_is_not(scene):
    record, config = _run(scene)
    assert record.times[-1] == pytest.approx(5 * PERIOD)
    record.poses[-1, 0, 4:] = [9.0, 0.0, 0.0]
    record.tracked[0] = False
    visibility = _diagnose(scene, record, config).visibility[:, 0]
    assert np.isnan(visibility[0])
    assert np.all(visibility[1:-1] > 0.9)
    assert visibility[-1] == 0.0
