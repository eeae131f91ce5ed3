import itertools

import numpy as np
import pytest
from result_fixtures import make_result
from scipy import stats

from pbpf_drake.diagrams.paper.paper_statistics import (
    Comparison,
    Interval,
    compare_means,
    confidence_band,
    mean_and_stddev,
    pool,
    sample_means,
)


def _runs(method: str, means, *, repeats: int = 2, spread: float = 0.0):
    """Results with these mean position errors of the runs."""
    return [
        make_result(
            method=method,
            run=run,
            repeat=repeat,
            errors={"position": mean + spread * (2 * repeat / repeats - 0.5)},
        )
        for run, mean in enumerate(means)
        for repeat in range(repeats)
    ]


def test_errors_are_pooled_over_runs_repeats_and_time():
    rng = np.random.default_rng(1)
    data = rng.random((3, 2, 5))
    results = [
        make_result(run=i, repeat=j, errors={"position": data[i, j]})
        for i in range(3)
        for j in range(2)
    ]
    values = pool(results, "cracker", "position")
    np.testing.assert_array_equal(np.sort(values), np.sort(data.ravel()))
    assert mean_and_stddev(values) == pytest.approx((data.mean(), data.std()))


def test_unknown_errors_are_not_pooled():
    results = [make_result(errors={"add": np.array([1, np.nan, 3, np.nan, 5])})]
    np.testing.assert_array_equal(pool(results, "cracker", "add"), [1, 3, 5])
    assert np.isnan(mean_and_stddev(np.empty(0))).all()


def test_samples_are_runs_and_repeats_where_there_is_one_run():
    many = _runs("pbpf", [1.0, 2.0], spread=0.1)
    assert sample_means(many, "cracker", "position") == {0: 1.0, 1: 2.0}
    one = _runs("pbpf", [1.0], spread=0.1)
    expected = pytest.approx({0: 0.95, 1: 1.05})
    assert sample_means(one, "cracker", "position") == expected


def test_a_clear_difference_is_significant_and_its_sign_is_right():
    rng = np.random.default_rng(2)
    small, large = 1 + 0.1 * rng.random((2, 10))
    large += 1
    better = compare_means(
        _runs("pbpf", small), _runs("dope", large), "cracker", "position"
    )
    worse = compare_means(
        _runs("pbpf", large), _runs("dope", small), "cracker", "position"
    )
    assert better.verdict() == "smaller" and worse.verdict() == "larger"
    assert (better.over, better.count) == ("runs", 10)
    assert better.difference.value == pytest.approx(small.mean() - large.mean())
    assert better.ratio.value == pytest.approx(small.mean() / large.mean())
    for interval in better.difference, better.ratio:
        assert interval.low < interval.value < interval.high


def test_intervals_of_a_difference_are_near_the_paired_t_test():
    rng = np.random.default_rng(3)
    common = 10 * rng.random(40)
    a, b = common + rng.normal(size=40), common + rng.normal(size=40) + 0.2
    found = compare_means(
        _runs("pbpf", a), _runs("cvpf", b), "cracker", "position"
    )
    low, high = stats.ttest_rel(a, b).confidence_interval(0.95)
    assert found.difference.low == pytest.approx(low, abs=0.08)
    assert found.difference.high == pytest.approx(high, abs=0.08)


def test_intervals_of_ten_runs_hold_the_truth_nine_times_in_ten(monkeypatch):
    """As the module says: they are a little short for so few."""
    monkeypatch.setattr(
        "pbpf_drake.diagrams.paper.paper_statistics._RESAMPLES", 999
    )
    rng, hits = np.random.default_rng(4), 0
    for _ in range(200):
        a, b = rng.normal(5, 1, size=(2, 10))
        found = compare_means(
            _runs("pbpf", a, repeats=1),
            _runs("dope", b, repeats=1),
            "cracker",
            "position",
        )
        hits += found.difference.low <= 0 <= found.difference.high
    # Three standard deviations of what 200 draws leave to chance.
    assert 0.90 * 200 - 13 <= hits <= 0.95 * 200 + 9


@pytest.mark.parametrize("draw", ["normal", "standard_cauchy"])
def test_equal_methods_differ_significantly_one_time_in_twenty(
    draw, monkeypatch
):
    monkeypatch.setattr(
        "pbpf_drake.diagrams.paper.paper_statistics._RESAMPLES", 1999
    )
    rng = np.random.default_rng(11)
    common = 10 * rng.random(10)
    false = 0
    for _ in range(200):
        a, b = common + getattr(rng, draw)(size=(2, 10))
        found = compare_means(
            _runs("pbpf", a, repeats=1),
            _runs("dope", b, repeats=1),
            "cracker",
            "position",
        )
        false += found.verdict() != "not different"
    assert false <= 0.05 * 200 + 9


def test_a_p_value_is_the_share_of_signs_that_make_as_large_a_difference():
    a, b = np.random.default_rng(12).normal(size=(2, 8))
    found = compare_means(
        _runs("pbpf", a), _runs("dope", b), "cracker", "position"
    )
    signs = np.array(list(itertools.product([-1, 1], repeat=8)))
    means = np.abs(signs @ (a - b)) / 8
    expected = np.mean(means >= abs(np.mean(a - b)) - 1e-12)
    assert found.p_value == pytest.approx(expected)


def test_one_run_alone_makes_no_significant_difference():
    """However large: that of all others says nothing."""
    a = np.full(10, 1.0)
    b = a + np.array([30.0, 0.2, -0.1, 0.1, -0.2, 0.1, 0.2, -0.1, -0.2, 0.1])
    found = compare_means(
        _runs("pbpf", a), _runs("dope", b), "cracker", "position"
    )
    assert found.verdict() == "not different"


def test_methods_are_compared_on_their_common_runs():
    first = _runs("pbpf", [1.0] * 8)
    second = _runs("dope", [2.0] * 6 + [99.0])[:-2]
    found = compare_means(first, second, "cracker", "position")
    assert found.count == 6
    assert found.difference == Interval(-1, -1, -1)
    assert found.ratio == Interval(0.5, 0.5, 0.5)


def test_what_is_not_random_has_the_same_error_in_each_repeat():
    first = _runs("pbpf-v", [1.0], repeats=20, spread=0.1)
    second = _runs("dope", [2.0], repeats=1)
    found = compare_means(first, second, "cracker", "position")
    assert (found.over, found.count) == ("repeats", 20)
    assert found.verdict() == "smaller"
    assert (
        compare_means(second, first, "cracker", "position").verdict()
        == "larger"
    )


def test_one_sample_or_none_in_common_is_not_compared():
    one = _runs("pbpf", [1.0], repeats=1)
    other = [make_result(method="dope", run=5)]
    assert compare_means(one, one, "cracker", "position") is None
    assert compare_means(one, other, "cracker", "position") is None


def test_few_runs_are_never_significant():
    for count in range(2, 6):
        found = compare_means(
            _runs("pbpf", np.linspace(1, 1.1, count)),
            _runs("dope", np.linspace(5, 5.2, count)),
            "cracker",
            "position",
        )
        assert found.verdict() == "too few"


def test_a_p_value_at_the_level_is_not_significant():
    interval = Interval(-1.0, -2.0, -0.5)
    ratio = Interval(0.5, 0.4, 0.9)
    for p_value, verdict in (0.05, "not different"), (0.049, "smaller"):
        dut = Comparison(interval, ratio, p_value, "runs", 10)
        assert dut.verdict() == verdict


def test_a_method_of_which_one_repeat_is_left_is_not_taken_to_be_exact():
    first = _runs("pbpf-v", [1.0], repeats=20, spread=0.1)
    second = _runs("pbpf", [2.0], repeats=1)
    assert compare_means(first, second, "cracker", "position") is None


def test_a_comparison_is_the_same_every_time():
    a, b = np.random.default_rng(5).random((2, 10))
    first, second = (
        compare_means(_runs("pbpf", a), _runs("dope", b), "cracker", "position")
        for _ in range(2)
    )
    assert first == second


def test_a_band_is_scipys_percentile_bootstrap(monkeypatch):
    monkeypatch.setattr(
        "pbpf_drake.diagrams.paper.paper_statistics._BAND_RESAMPLES", 20_000
    )
    samples = np.random.default_rng(6).normal(size=(12, 30))
    mean, low, high = confidence_band(samples, np.random.default_rng(7))
    expected = stats.bootstrap(
        (samples,),
        np.mean,
        axis=0,
        method="percentile",
        n_resamples=20_000,
        rng=np.random.default_rng(8),
    ).confidence_interval
    np.testing.assert_allclose(mean, samples.mean(axis=0))
    # Four times what 20 000 draws leave to chance.
    np.testing.assert_allclose(low, expected.low, atol=0.035)
    np.testing.assert_allclose(high, expected.high, atol=0.035)


def test_a_band_of_one_run_is_its_line_and_unknown_times_are_unknown():
    samples = np.array([[1.0, np.nan, 3.0]])
    for line in confidence_band(samples, np.random.default_rng(8)):
        np.testing.assert_array_equal(line, samples[0])


def test_a_band_leaves_out_runs_that_are_unknown_at_a_time():
    samples = np.array([[1.0, 2.0], [np.nan, 4.0], [3.0, 6.0]])
    mean, low, high = confidence_band(samples, np.random.default_rng(9))
    np.testing.assert_allclose(mean, [2.0, 4.0])
    assert np.all(low <= mean) and np.all(mean <= high)
    np.testing.assert_array_equal([low[0], high[0]], [1.0, 3.0])
