import numpy as np
import pytest
from recording_fixtures import make_planar_scene

from pbpf_drake.truth.truth_parameters import draw_truth_parameters


def test_parameters_are_drawn_from_their_ranges():
    config = make_planar_scene().recording
    config.mass_scale.max = 2.0
    rng = np.random.default_rng(0)
    draws = [draw_truth_parameters(config, 3, rng) for _ in range(200)]
    for name in "mass_scale", "friction", "robot_friction":
        values = np.array([getattr(d, name) for d in draws])
        low, high = getattr(config, name).min, getattr(config, name).max
        assert values.min() == pytest.approx(low, abs=0.02 * (high - low))
        assert values.max() == pytest.approx(high, abs=0.02 * (high - low))
        assert low <= values.min() and values.max() <= high
    assert draws[0].mass_scale.shape == (3,)
    assert len(set(draws[0].mass_scale)) == 3


def test_starts_scatter_as_configured():
    config = make_planar_scene().recording
    config.start_stddev.position = 0.02
    config.start_stddev.rotation = 0.3
    rng = np.random.default_rng(0)
    starts = np.concatenate(
        [draw_truth_parameters(config, 4, rng).starts for _ in range(500)]
    )
    assert starts.shape == (2000, 3)
    np.testing.assert_allclose(starts.std(axis=0), [0.02, 0.02, 0.3], rtol=0.06)
