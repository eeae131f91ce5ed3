import numpy as np
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.dope_measurement import Detection, DopeMeasurement
from pbpf_drake.filtering.recent_detections import (
    add_measurement,
    make_empty_rows,
    unused_detections,
)

NAMES = ("box", "can")
NEVER = np.full(2, -np.inf)


def _add(rows: np.ndarray, now: float, **stamps: float) -> np.ndarray:
    """Adds detections of objects that are at (stamp, 0, 0)."""
    measurement = DopeMeasurement(
        {k: Detection(RigidTransform([t, 0, 0]), t) for k, t in stamps.items()}
    )
    return add_measurement(
        rows, measurement, object_names=NAMES, now=now, max_age=0.25
    )


def _stamps(rows: np.ndarray, k: int) -> list[float]:
    return [seen.time for seen in unused_detections(rows, NEVER).get(k, [])]


def test_detections_are_kept_per_object_in_the_order_of_their_stamps():
    rows = make_empty_rows(2, 3)
    for now, stamps in (
        (0.1, {"can": 0.05}),
        (0.2, {"can": 0.05, "box": 0.15}),
        (0.3, {"can": 0.25, "box": 0.15}),
    ):
        rows = _add(rows, now, **stamps)
    assert _stamps(rows, 0) == [0.15]
    assert _stamps(rows, 1) == [0.05, 0.25]
    (seen,) = unused_detections(rows, NEVER)[0]
    np.testing.assert_allclose(seen.pose, [1, 0, 0, 0, 0.15, 0, 0])


def test_what_an_update_has_used_is_not_new():
    rows = _add(make_empty_rows(2, 3), 0.1, box=0.05, can=0.1)
    rows = _add(rows, 0.2, box=0.15, can=0.1)
    unused = unused_detections(rows, np.array([0.05, 0.1]))
    assert {k: [s.time for s in seen] for k, seen in unused.items()} == {
        0: [0.15]
    }


def test_of_too_many_the_latest_are_kept():
    rows = make_empty_rows(2, 3)
    for i in range(1, 6):
        rows = _add(rows, 0.1 * i, box=0.1 * i)
    np.testing.assert_allclose(_stamps(rows, 0), [0.3, 0.4, 0.5])


@pytest.mark.parametrize(
    "now, stamp, used",
    [
        pytest.param(1.0, 0.75, True, id="just young enough"),
        pytest.param(1.0, 0.74, False, id="too old"),
        pytest.param(1.0, 1.0, True, id="of now"),
        pytest.param(1.0, 1.0 + 1e-9, True, id="of now but for rounding"),
        pytest.param(1.0, 1.1, False, id="of the future"),
        pytest.param(1.0, np.nan, False, id="without a time"),
        pytest.param(1001.0, 1001.0, False, id="out of range"),
    ],
)
def test_only_what_can_be_used_is_kept(now, stamp, used):
    rows = _add(make_empty_rows(2, 3), now, box=stamp)
    assert _stamps(rows, 0) == ([stamp] if used else [])


def test_the_rows_that_are_given_stay_as_they_are():
    rows = make_empty_rows(2, 3)
    _add(rows, 0.1, box=0.1)
    np.testing.assert_array_equal(rows, make_empty_rows(2, 3))
