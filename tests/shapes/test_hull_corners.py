import numpy as np
import pytest
from scipy.spatial import ConvexHull, QhullError

from pbpf_drake.shapes.hull_corners import choose_hull_corners


def _ball(n: int) -> np.ndarray:
    points = np.random.default_rng(1).normal(size=(n, 3))
    return points / np.linalg.norm(points, axis=1, keepdims=True)


def _error(points: np.ndarray, kept: np.ndarray) -> float:
    """How far a point is outside of the hull of the kept ones."""
    planes = ConvexHull(points[kept]).equations
    return float((planes[:, :3] @ points.T + planes[:, 3:]).max())


def test_all_corners_are_kept_where_there_are_few():
    points = np.vstack([_ball(40), 0.5 * _ball(60)])
    np.testing.assert_array_equal(choose_hull_corners(points, 64), range(40))


@pytest.mark.parametrize("most", [26, 64, 200])
def test_no_more_than_most_are_kept(most):
    kept = choose_hull_corners(_ball(3000), most)
    assert len(kept) <= most
    assert len(np.unique(kept)) == len(kept)


def test_more_corners_are_nearer_to_the_whole_hull():
    points = _ball(3000)
    errors = [
        _error(points, choose_hull_corners(points, n)) for n in (32, 64, 256)
    ]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.03


def test_the_kept_ones_dont_depend_on_size_or_place():
    points = _ball(1000)
    kept = choose_hull_corners(points, 64)
    moved = choose_hull_corners(1000 * points + [3.0, 0.0, -5.0], 64)
    assert _error(points, moved) == pytest.approx(_error(points, kept), rel=0.5)


def test_what_is_flat_has_no_hull():
    with pytest.raises(QhullError):
        choose_hull_corners(_ball(50) * [1, 1, 0], 64)
