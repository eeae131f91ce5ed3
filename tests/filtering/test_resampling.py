import numpy as np
import pytest

from pbpf_drake.filtering.resampling import (
    effective_sample_size,
    normalize_log_weights,
    systematic_resample,
)


def test_log_weights_are_normalized_whatever_their_constant():
    log_weights = np.array([0.0, np.log(3.0), -np.inf])
    for constant in (0.0, -1e5, 1e5):
        np.testing.assert_allclose(
            normalize_log_weights(log_weights + constant), [0.25, 0.75, 0.0]
        )


def test_weights_without_information_are_uniform():
    for value in (-np.inf, np.nan):
        np.testing.assert_array_equal(
            normalize_log_weights(np.full(4, value)), np.full(4, 0.25)
        )


def test_a_nan_costs_only_its_particle():
    np.testing.assert_array_equal(
        normalize_log_weights(np.array([0.0, np.nan, 0.0])), [0.5, 0.0, 0.5]
    )


def test_effective_sample_size_of_uniform_and_of_one_hot_weights():
    assert effective_sample_size(np.full(8, 1 / 8)) == pytest.approx(8)
    assert effective_sample_size(np.eye(8)[3]) == pytest.approx(1)


@pytest.mark.parametrize("u", [0.001, 0.3, 0.999])
def test_uniform_weights_keep_every_particle(u):
    weights = np.full(70, 1 / 70)
    counts = np.bincount(systematic_resample(weights, u), minlength=70)
    np.testing.assert_array_equal(counts, 1)


@pytest.mark.parametrize("u", [0.0, 0.5, 1 - 1e-16])
def test_one_hot_weights_keep_one_particle(u):
    assert set(systematic_resample(np.eye(5)[2], u)) == {2}


def test_fewer_or_more_can_survive():
    weights = np.array([0.1, 0.5, 0.0, 0.4])
    # Teeth at 0.25 and 0.75; and at 0.05, 0.15, …, 0.95.
    np.testing.assert_array_equal(systematic_resample(weights, 0.5, 2), [1, 3])
    np.testing.assert_array_equal(
        systematic_resample(weights, 0.5, 10), [0] + [1] * 5 + [3] * 4
    )


def test_ancestors_of_a_hand_computed_case():
    # Cumulated 0.1, 0.6, 0.6, 1.0; teeth at 0.125, 0.375, 0.625, 0.875.
    weights = np.array([0.1, 0.5, 0.0, 0.4])
    np.testing.assert_array_equal(
        systematic_resample(weights, 0.5), [1, 1, 3, 3]
    )


def test_counts_are_the_rounded_expectation_and_right_on_average():
    rng = np.random.default_rng(0)
    weights = rng.dirichlet(np.full(20, 0.5))
    counts = np.array(
        [
            np.bincount(systematic_resample(weights, u), minlength=20)
            for u in (np.arange(2000) + 0.5) / 2000
        ]
    )
    assert np.all(counts >= np.floor(20 * weights))
    assert np.all(counts <= np.ceil(20 * weights))
    np.testing.assert_allclose(counts.mean(axis=0), 20 * weights, atol=2e-3)
