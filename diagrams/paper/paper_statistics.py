"""Means over runs, and how sure they are.

The paper pools the errors of all time steps of all evaluations. How sure a
difference is depends on the number of runs, not on the number of time steps or
repeats, which share the same images. So confidence intervals are found by
drawing runs with replacement (bootstrap). Where there is only one run, its
repeats are drawn instead; that says nothing about other runs.

The intervals of ten runs are a little short: they hold the truth about nine
times in ten. So whether two methods differ is decided by a test that is exact
for any number of runs. It asks how likely the differences are if each run's
difference could as well have the other sign, as it could if the methods were
equal.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
import warnings

import numpy as np
from scipy import stats

from pbpf_drake.diagrams.paper.evaluation import Result

_CONFIDENCE = 0.95
# A difference is significant if chance alone makes one as large less often than
# this.
_SIGNIFICANCE = 0.05
_RESAMPLES = 9999
_BAND_RESAMPLES = 4000
# With fewer samples nothing is significant: the chance that n samples all
# differ to the same side is 2 / 2^n, which is below _SIGNIFICANCE from n = 6
# on.
_FEWEST = 6

_Statistic = Callable[..., np.ndarray]


@dataclass(frozen=True)
class Interval:
    """An estimate and the ends of its 95 % confidence interval."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Comparison:
    """How the mean errors of two methods compare.

    Attributes:
        difference: the first mean minus the second.
        ratio: the first mean over the second.
        p_value: how often chance alone makes a difference as large, of either
            sign (paired permutation test).
        over: "runs" or "repeats", whichever are the samples.
        count: how many of them there are.
    """

    difference: Interval
    ratio: Interval
    p_value: float
    over: str
    count: int

    def verdict(self) -> str:
        """Returns "smaller", "larger", "not different" or "too few"."""
        if self.count < _FEWEST:
            return "too few"
        if not self.p_value < _SIGNIFICANCE:
            return "not different"
        return "smaller" if self.difference.value < 0 else "larger"


def pool(
    results: Sequence[Result], object_name: str, metric: str
) -> np.ndarray:
    """Returns the known errors of all results and times, (n,)."""
    parts = [result.errors[object_name][metric] for result in results]
    values = np.concatenate([np.empty(0), *parts])
    return values[np.isfinite(values)]


def mean_and_stddev(values: np.ndarray) -> tuple[float, float]:
    """Returns both; NaN where there are no values."""
    if not values.size:
        return float("nan"), float("nan")
    return float(np.mean(values)), float(np.std(values))


def sample_means(
    results: Sequence[Result], object_name: str, metric: str
) -> dict[int, float]:
    """Returns the mean error of each run, or of each repeat of a single run.

    Those without a known error are left out.
    """
    groups: dict[int, list[Result]] = {}
    runs = {result.run for result in results}
    for result in results:
        group = result.run if len(runs) > 1 else result.repeat
        groups.setdefault(group, []).append(result)
    pooled = {g: pool(r, object_name, metric) for g, r in groups.items()}
    return {g: float(np.mean(x)) for g, x in pooled.items() if x.size}


def compare_means(
    first: Sequence[Result],
    second: Sequence[Result],
    object_name: str,
    metric: str,
) -> Comparison | None:
    """Compares two methods on the runs that both were evaluated on.

    Args:
        first, second: results of one scene and one method each.
        object_name: of the tracked model.
        metric: one of METRICS.

    Returns:
        None where fewer than two runs, or repeats of one run, are common.
    """
    runs = {r.run for r in first} & {r.run for r in second}
    a, b = (
        sample_means([r for r in x if r.run in runs], object_name, metric)
        for x in (first, second)
    )
    if len(runs) == 1:
        a, b = _fill(a, b, first), _fill(b, a, second)
    common = sorted(set(a) & set(b))
    if len(common) < 2:
        return None
    pairs = (
        np.array([a[i] for i in common]),
        np.array([b[i] for i in common]),
    )
    return Comparison(
        difference=_bootstrap(pairs, _difference),
        ratio=_bootstrap(pairs, _ratio),
        p_value=_p_value(pairs),
        over="runs" if len(runs) > 1 else "repeats",
        count=len(common),
    )


def confidence_band(
    samples: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns means over time, and the ends of their confidence intervals.

    Args:
        samples: (R, T) errors of R runs, NaN where unknown.
        rng: draws runs with replacement.

    Returns:
        Mean, low and high, (T,) each; NaN where no run is known. With one run
        there is no band: low and high are the mean.
    """
    known = np.isfinite(samples)
    values = np.where(known, samples, 0.0)
    number = len(samples)

    def means(weights: np.ndarray) -> np.ndarray:
        total, count = weights @ values, weights @ known
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)

    mean = means(np.ones((1, number)))[0]
    drawn = means(
        rng.multinomial(number, np.full(number, 1 / number), _BAND_RESAMPLES)
    )
    # A draw may have none of the runs that are known at a time.
    drawn = np.where(np.isfinite(drawn), drawn, mean)
    tail = 50 * (1 - _CONFIDENCE)
    low, high = np.percentile(drawn, [tail, 100 - tail], axis=0)
    return mean, low, high


def _fill(
    means: dict[int, float], other: dict[int, float], results: Sequence[Result]
) -> dict[int, float]:
    """Returns means for all repeats that the other method has, if it's DOPE.

    DOPE draws nothing at random, so it is evaluated once, and each of its
    repeats would have the same mean.
    """
    if means and {result.method for result in results} == {"dope"}:
        return dict.fromkeys(other, *means.values())
    return means


def _difference(a: np.ndarray, b: np.ndarray, axis: int = -1) -> np.ndarray:
    return np.mean(a, axis=axis) - np.mean(b, axis=axis)


def _ratio(a: np.ndarray, b: np.ndarray, axis: int = -1) -> np.ndarray:
    return np.mean(a, axis=axis) / np.mean(b, axis=axis)


def _p_value(pairs: tuple[np.ndarray, np.ndarray]) -> float:
    """Returns how often chance alone makes as large a mean difference.

    All combinations of signs are tried, or _RESAMPLES random ones if there are
    more than that.
    """
    return float(
        stats.permutation_test(
            (pairs[0] - pairs[1],),
            np.mean,
            permutation_type="samples",
            vectorized=True,
            n_resamples=_RESAMPLES,
            rng=np.random.default_rng(0),
        ).pvalue
    )


def _bootstrap(
    pairs: tuple[np.ndarray, np.ndarray], statistic: _Statistic
) -> Interval:
    """Returns a statistic of paired samples, with its interval.

    The interval is the bias-corrected and accelerated one (BCa) if it exists.
    """
    value = float(statistic(*pairs))
    if not np.isfinite(value):
        return Interval(value, float("nan"), float("nan"))
    left_out = [
        statistic(*(np.delete(x, i) for x in pairs))
        for i in range(len(pairs[0]))
    ]
    if np.ptp(left_out) <= 1e-12 * max(abs(value), 1e-300):
        # All samples are equal, for which no interval is defined.
        return Interval(value, value, value)
    interval = _interval(pairs, statistic, "BCa")
    if not np.all(np.isfinite(interval)):
        interval = _interval(pairs, statistic, "percentile")
    return Interval(value, *interval)


def _interval(
    pairs: tuple[np.ndarray, np.ndarray], statistic: _Statistic, method: str
) -> tuple[float, float]:
    """Returns low and high; NaN where the method has none."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", stats.DegenerateDataWarning)
        found = stats.bootstrap(
            pairs,
            statistic,
            paired=True,
            vectorized=True,
            n_resamples=_RESAMPLES,
            confidence_level=_CONFIDENCE,
            method=method,
            rng=np.random.default_rng(0),
        ).confidence_interval
    return float(found.low), float(found.high)
