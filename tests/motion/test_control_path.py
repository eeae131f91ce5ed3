import numpy as np
import pytest

from pbpf_drake.motion.control_path import (
    ControlPath,
    add_hermite_midpoints,
    simplify_path,
)


def _random_path(n: int, seed: int, joints: int = 3) -> ControlPath:
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.01, 0.03, n))
    walk = np.cumsum(rng.standard_normal((n, joints)), axis=0)
    return ControlPath(times, 1e-3 * walk)


def _at(path: ControlPath, times: np.ndarray) -> np.ndarray:
    return np.column_stack(
        [np.interp(times, path.times, column) for column in path.positions.T]
    )


def test_midpoints_lie_on_the_cubic_of_positions_and_velocities():
    rng = np.random.default_rng(0)
    coefficients = rng.standard_normal((4, 2))
    times = np.cumsum(rng.uniform(0.1, 0.5, 6))

    def cubic(t):
        return np.vander(t, 4) @ coefficients

    def rate(t):
        return np.vander(t, 3) @ (coefficients[:3] * [[3], [2], [1]])

    path = add_hermite_midpoints(ControlPath(times, cubic(times)), rate(times))
    middles = (times[1:] + times[:-1]) / 2
    np.testing.assert_allclose(path.times, np.sort([*times, *middles]))
    np.testing.assert_allclose(path.positions, cubic(path.times), atol=1e-12)


def test_points_that_were_given_stay_as_they_are():
    path = _random_path(5, seed=1)
    denser = add_hermite_midpoints(path, np.ones((5, 3)))
    np.testing.assert_array_equal(denser.times[::2], path.times)
    np.testing.assert_array_equal(denser.positions[::2], path.positions)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("tolerance", [0.0, 1e-4, 1e-3, 1e-2])
def test_a_simplified_path_is_within_the_tolerance(seed, tolerance):
    path = _random_path(40, seed)
    simple = simplify_path(path, tolerance)
    # Both are straight between their points, so the whole error is at them.
    error = np.abs(_at(simple, path.times) - path.positions)
    assert np.max(error) <= tolerance + 1e-15
    rows = np.searchsorted(path.times, simple.times)
    np.testing.assert_array_equal(path.positions[rows], simple.positions)
    assert rows[0] == 0 and rows[-1] == 39


def test_a_looser_tolerance_keeps_fewer_points():
    path = _random_path(100, seed=7)
    counts = [
        len(simplify_path(path, tolerance).times)
        for tolerance in (1e-5, 1e-3, 4e-3, 1.0)
    ]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[1] > counts[2] > counts[3] == 2


def test_a_straight_line_becomes_its_two_ends():
    times = np.array([0.0, 0.1, 0.15, 0.4, 0.5])
    path = ControlPath(times, np.outer(times, [1.0, -2.0, 0.0]))
    simple = simplify_path(path, 1e-12)
    np.testing.assert_array_equal(simple.times, [0.0, 0.5])
    np.testing.assert_array_equal(simple.positions, path.positions[[0, -1]])


def test_a_corner_is_kept_where_it_is():
    times = np.linspace(0.0, 1.0, 11)
    path = ControlPath(times, np.maximum(times - 0.3, 0.0)[:, None])
    simple = simplify_path(path, 1e-9)
    np.testing.assert_allclose(simple.times, [0.0, 0.3, 1.0])


def test_two_points_are_a_path():
    path = ControlPath(np.array([0.0, 0.16]), np.zeros((2, 3)))
    simple = simplify_path(path, 5e-4)
    np.testing.assert_array_equal(simple.times, path.times)


def test_a_path_of_no_joints_is_simple():
    path = ControlPath(np.linspace(0.0, 1.0, 5), np.zeros((5, 0)))
    np.testing.assert_array_equal(simplify_path(path, 1e-3).times, [0.0, 1.0])
