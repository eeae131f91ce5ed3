import numpy as np

from pbpf_drake.motion.ticks import TICK, to_ticks


def test_times_are_moved_by_half_a_tick_at_most():
    times = np.random.default_rng(0).uniform(0.0, 1.0, 1000)
    found = to_ticks(times)
    assert np.abs(found - times).max() <= TICK / 2
    np.testing.assert_array_equal(found / TICK, np.round(found / TICK))


def test_sums_of_ticks_are_exact():
    """As long as a filter may run: what is added can be taken away again."""
    a_century = 100 * 365.25 * 24 * 3600
    starts = to_ticks(np.random.default_rng(0).uniform(0, a_century, 1000))
    steps = to_ticks(np.random.default_rng(1).uniform(0, 1, 1000))
    np.testing.assert_array_equal((starts + steps) - starts, steps)
