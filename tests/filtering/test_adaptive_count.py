import numpy as np
import pytest
from scipy.stats import chi2, norm

from pbpf_drake.config.adaptive_count_config import AdaptiveCountConfig
from pbpf_drake.filtering.adaptive_count import (
    bin_labels,
    kld_sample_size,
    needed_particles,
)
from pbpf_drake.filtering.resampling import systematic_resample
from pbpf_drake.poses.quaternions import from_rotation_vector

CENTER = np.array([[1.0, 0, 0, 0, 0.3, -0.2, 0.1]])
CONFIG = AdaptiveCountConfig(
    min_particles=10, max_divergence=0.1, confidence=0.95
)


def test_one_bin_needs_one_particle():
    assert kld_sample_size(1, 0.05, 0.99) == 1


@pytest.mark.parametrize("k", [2, 10, 500])
@pytest.mark.parametrize("z", [-1.0, 0.0, 1.0, 2.326])
def test_the_size_is_the_closed_form(k, z):
    x = 2 / (9 * (k - 1))
    expected = (k - 1) / (2 * 0.01) * (1 - x + np.sqrt(x) * z) ** 3
    size = kld_sample_size(k, 0.01, norm.cdf(z))
    assert expected - 1e-6 <= size < max(expected, 1) + 1


@pytest.mark.parametrize("k", [2, 3, 10, 100, 3000])
@pytest.mark.parametrize("confidence", [0.9, 0.95, 0.99])
def test_the_size_is_by_the_quantile_of_chi_square(k, confidence):
    expected = chi2.ppf(confidence, k - 1) / (2 * 1e-4)
    assert kld_sample_size(k, 1e-4, confidence) == pytest.approx(
        expected, rel=0.03
    )


def test_so_many_samples_are_as_near_to_the_belief_as_is_asked_for():
    rng, belief = np.random.default_rng(3), np.arange(10.0, 40.0)
    belief /= belief.sum()
    size = kld_sample_size(30, 0.02, 0.9)
    shares = rng.multinomial(size, belief, size=4000) / size
    ratio = np.where(shares > 0, shares / belief, 1.0)
    divergence = np.sum(shares * np.log(ratio), axis=1)
    assert np.mean(divergence <= 0.02) == pytest.approx(0.9, abs=0.02)


def test_a_narrow_belief_is_in_one_bin_whatever_the_signs():
    rng = np.random.default_rng(1)
    poses = np.tile(CENTER, (100, 1, 1))
    poses[:, 0, 4:] += rng.uniform(-0.009, 0.009, (100, 3))
    poses[:, 0, :4] = from_rotation_vector(rng.uniform(-0.04, 0.04, (100, 3)))
    poses[::2, 0, :4] *= -1
    assert len(np.unique(bin_labels(poses, CENTER, (0.02, 0.1)))) == 1


@pytest.mark.parametrize("axis", range(6))
def test_bins_are_as_wide_as_is_asked_for_along_every_axis(axis):
    offsets = np.zeros((50, 6))
    offsets[:, axis] = np.arange(50) * (0.01 if axis < 3 else 0.05)
    poses = np.tile(CENTER, (50, 1, 1))
    poses[:, 0, 4:] += offsets[:, :3]
    poses[:, 0, :4] = from_rotation_vector(offsets[:, 3:])
    # Two poses in each, and not on an edge.
    labels = bin_labels(poses, poses[0] + [[0] * 4 + [1e-4] * 3],
                        (0.02, 0.1001))[:, 0]  # fmt: skip
    sizes = np.bincount(labels)
    assert len(sizes) == pytest.approx(25, abs=1)
    assert sizes.max() == 2


def test_objects_have_bins_of_their_own():
    poses = np.tile(CENTER, (10, 2, 1))
    poses[:, 1, 4] += np.arange(10)
    labels = bin_labels(poses, np.repeat(CENTER, 2, axis=0), (0.02, 0.1))
    assert [len(np.unique(x)) for x in labels.T] == [1, 10]


def _needed(labels, most=1000, weights=None, efficiency=1.0):
    labels = np.reshape(labels, (len(labels), -1))
    if weights is None:
        weights = np.full(len(labels), 1 / len(labels))
    return needed_particles(
        labels, weights, 0.3, efficiency=efficiency, most=most, config=CONFIG
    )


def test_one_bin_needs_the_fewest_and_many_bins_all():
    assert _needed(np.zeros(200, dtype=int)) == 10
    assert _needed(np.zeros(200, dtype=int), most=7) == 7
    assert _needed(np.arange(200), most=150) == 150
    assert _needed(np.zeros((200, 0), dtype=int)) == 10


@pytest.mark.parametrize(
    "labels", [np.zeros(200, dtype=int), np.arange(200) % 5]
)
def test_particles_that_are_worth_a_quarter_are_needed_four_times(labels):
    assert _needed(labels, efficiency=0.25) == 4 * _needed(labels)
    assert _needed(labels, efficiency=1e-3, most=99) == 99


def test_bins_without_weight_do_not_count():
    weights = np.zeros(200)
    weights[7:9] = 0.5
    labels = np.arange(200)
    assert _needed(labels, weights=weights) == _needed([0, 1])


def test_the_object_with_most_bins_counts():
    one, other = np.arange(200) % 12, np.arange(200) % 3
    assert _needed(np.stack([other, one], axis=1)) == _needed(one)
    assert _needed(one) > _needed(other)


@pytest.mark.parametrize("num_bins", [2, 5, 20])
def test_what_is_returned_is_enough_for_its_own_bins(num_bins):
    rng = np.random.default_rng(num_bins)
    labels, weights = rng.integers(num_bins, size=300), rng.random(300)
    weights /= weights.sum()
    count = _needed(labels, weights=weights)
    survivors = systematic_resample(weights, 0.3, count)
    in_bins = len(np.unique(labels[survivors]))
    assert in_bins == num_bins
    assert count == max(10, kld_sample_size(num_bins, 0.1, 0.95))
