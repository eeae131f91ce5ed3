import numpy as np
import pytest

from pbpf_drake.filtering.joint_samples import (
    append_row,
    make_empty_rows,
    make_row,
    path_since,
)


def _samples(*times: float, count: int = 4) -> np.ndarray:
    """Samples of two joints: one is at its time, the other at its square."""
    samples = make_empty_rows(count, 2)
    for t in times:
        row = make_row(
            t, np.array([t, t * t]), np.array([1, 2 * t]), samples[-1]
        )
        samples = append_row(samples, row)
    return samples


def test_rows_that_are_not_filled_are_no_part_of_the_path():
    path = path_since(_samples(0.0, 0.1), -1.0, bend=False)
    np.testing.assert_array_equal(path.times, [0.0, 0.1])
    np.testing.assert_allclose(path.positions, [[0, 0], [0.1, 0.01]])


def test_the_oldest_row_makes_room_for_a_new_one():
    samples = _samples(0.0, 0.1, 0.2, 0.3, 0.4)
    np.testing.assert_allclose(samples[:, 0], [0.1, 0.2, 0.3, 0.4])


def test_a_sample_of_the_same_time_takes_the_place_of_the_last():
    samples = _samples(0.0, 0.1)
    again = make_row(0.1, np.array([7.0, 8.0]), None, samples[-1])
    samples = append_row(samples, again)
    np.testing.assert_allclose(samples[-2:, 0], [0.0, 0.1])
    np.testing.assert_allclose(samples[-1, 1:], [7, 8, 0, 0])


def test_what_is_not_finite_is_held():
    last = make_row(
        0.0, np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.zeros(5)
    )
    sample = make_row(
        0.1, np.array([np.nan, 5.0]), np.array([6.0, np.inf]), last
    )
    np.testing.assert_allclose(sample, [0.1, 1.0, 5.0, 6.0, 4.0])


@pytest.mark.parametrize(
    "since, times",
    [
        pytest.param(0.1, [0.1, 0.2, 0.3], id="at a sample"),
        pytest.param(0.15, [0.1, 0.2, 0.3], id="between two"),
        pytest.param(-1.0, [0.0, 0.1, 0.2, 0.3], id="before the first"),
        pytest.param(0.3, [0.3], id="at the last"),
    ],
)
def test_the_path_starts_at_the_last_sample_until_then(since, times):
    path = path_since(_samples(0.0, 0.1, 0.2, 0.3), since, bend=False)
    np.testing.assert_allclose(path.times, times)


def test_velocities_bend_the_path_to_what_has_them():
    """A parabola is its own cubic, so points amid the samples are on it."""
    path = path_since(_samples(0.0, 0.1, 0.3), -1.0, bend=True)
    np.testing.assert_allclose(path.times, [0.0, 0.05, 0.1, 0.2, 0.3])
    np.testing.assert_allclose(path.positions[:, 0], path.times, atol=1e-15)
    np.testing.assert_allclose(path.positions[:, 1], path.times**2, atol=1e-15)
