from dataclasses import replace

import numpy as np
import pytest

from pbpf_drake.config.detector_config import DetectorConfig
from pbpf_drake.config.distributions import Range
from pbpf_drake.truth.detection_outliers import draw_outlier_error

N = 20_000
CONFIG = DetectorConfig(
    outlier_position=Range(min=0.2, max=0.6),
    outlier_rotation=Range(min=0.5, max=2.5),
)


def _draw(
    occlusion: float, *, chance: float = 1.0, count: int = N, seed: int = 0
) -> np.ndarray:
    """Returns errors (count, 2, 3): rotation vectors, then translations."""
    config = replace(CONFIG, outlier_chance=chance)
    rng = np.random.default_rng(seed)
    errors = [draw_outlier_error(occlusion, config, rng) for _ in range(count)]
    return np.reshape(errors, (count, 2, 3))


def _sizes(errors: np.ndarray) -> np.ndarray:
    """Returns (2, N): angles and distances."""
    return np.linalg.norm(errors, axis=-1).T


@pytest.fixture(scope="module")
def deep() -> np.ndarray:
    """Errors where the object is hardly detected: all are outliers."""
    return _draw(1.0)


def test_angles_are_uniform(deep):
    angles, _ = _sizes(deep)
    assert 0.5 <= angles.min() < 0.51 and 2.49 < angles.max() <= 2.5
    share = np.array([0.1, 0.25, 0.5, 0.75, 0.9])
    np.testing.assert_allclose(
        np.quantile(angles, share), 0.5 + 2 * share, atol=0.04
    )


@pytest.mark.parametrize("occlusion", [0.2, 0.6, 1.0])
def test_distances_are_in_the_farther_half_of_a_logarithmic_way(occlusion):
    _, distances = _sizes(_draw(occlusion))
    distances = distances[distances > 0]
    way = np.sqrt(occlusion)
    low, high = 0.2 * 3 ** (way / 2), 0.2 * 3**way
    assert low <= distances.min() < low + 2e-3
    assert high - 2e-3 < distances.max() <= high + 1e-12
    mean = (high - low) / np.log(high / low)
    assert distances.mean() == pytest.approx(mean, abs=0.004)
    assert np.median(distances) == pytest.approx(np.sqrt(low * high), abs=5e-3)


def test_outliers_are_off_in_all_directions_alike(deep):
    for errors in np.moveaxis(deep, 1, 0):
        units = errors / np.linalg.norm(errors, axis=1, keepdims=True)
        np.testing.assert_allclose(units.mean(axis=0), 0, atol=0.02)
        np.testing.assert_allclose(
            units.T @ units / N, np.eye(3) / 3, atol=0.015
        )


@pytest.mark.parametrize("occlusion, chance", [(0.2, 1.0), (0.8, 0.5)])
def test_position_and_rotation_are_outliers_each_by_itself(occlusion, chance):
    turned, shifted = _sizes(_draw(occlusion, chance=chance)) > 0
    p = occlusion * chance
    assert turned.mean() == pytest.approx(p, abs=0.015)
    assert shifted.mean() == pytest.approx(p, abs=0.015)
    assert np.mean(turned & shifted) == pytest.approx(p * p, abs=0.015)


def test_outliers_come_one_by_one():
    for is_off in _sizes(_draw(0.5)) > 0:
        changes = np.mean(is_off[1:] != is_off[:-1])
        assert changes == pytest.approx(0.5, abs=0.015)


@pytest.mark.parametrize("occlusion, chance", [(0.0, 1.0), (1.0, 0.0)])
def test_what_is_no_outlier_is_not_off_at_all(occlusion, chance):
    np.testing.assert_array_equal(
        _draw(occlusion, chance=chance, count=100), 0.0
    )


def test_more_occlusion_adds_outliers_and_keeps_those_there_were():
    less, more = _draw(0.3, count=500), _draw(0.6, count=500)
    kept = _sizes(less) > 0
    assert np.all(_sizes(more)[kept] > 0)
    assert 1.5 < np.sum(_sizes(more) > 0) / np.sum(kept) < 2.5
    np.testing.assert_array_equal(more[kept[0], 0], less[kept[0], 0])
    far, near = more[kept[1], 1], less[kept[1], 1]
    np.testing.assert_allclose(np.cross(far, near), 0, atol=1e-12)
    assert np.all(np.sum(far * near, axis=1) > np.sum(near * near, axis=1))


def test_outliers_are_a_function_of_the_seed():
    first = _draw(0.5, count=50)
    np.testing.assert_array_equal(first, _draw(0.5, count=50))
    assert not np.array_equal(first, _draw(0.5, count=50, seed=1))
