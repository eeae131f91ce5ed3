import numpy as np
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.dope_measurement import Detection, DopeMeasurement
from pbpf_drake.filtering.recent_detections import (
    DETECTION_FATES,
    RecentDetections,
    add_measurement,
    make_no_detections,
)

NAMES = ("box", "can")
NEVER = np.full(2, -np.inf)
BOUNDS = np.array([[-2.0] * 3, [2.0] * 3])


def _add(
    rows: RecentDetections, now: float, **stamps: float
) -> RecentDetections:
    """Adds detections of objects that are at (stamp, 0, 0)."""
    measurement = DopeMeasurement(
        {k: Detection(RigidTransform([t, 0, 0]), t) for k, t in stamps.items()}
    )
    return add_measurement(
        rows,
        measurement,
        object_names=NAMES,
        now=now,
        max_age=0.25,
        bounds=BOUNDS,
    )


def _stamps(rows: RecentDetections, k: int) -> list[float]:
    return [seen.time for seen in rows.unused(NEVER).get(k, [])]


def test_detections_are_kept_per_object_in_the_order_of_their_stamps():
    rows = make_no_detections(2, 3)
    for now, stamps in (
        (0.1, {"can": 0.05}),
        (0.2, {"can": 0.05, "box": 0.15}),
        (0.3, {"can": 0.25, "box": 0.15}),
    ):
        rows = _add(rows, now, **stamps)
    assert _stamps(rows, 0) == [0.15]
    assert _stamps(rows, 1) == [0.05, 0.25]
    (seen,) = rows.unused(NEVER)[0]
    np.testing.assert_allclose(seen.pose, [1, 0, 0, 0, 0.15, 0, 0])


def test_what_an_update_has_used_is_not_new():
    rows = _add(make_no_detections(2, 3), 0.1, box=0.05, can=0.1)
    rows = _add(rows, 0.2, box=0.15, can=0.1)
    unused = rows.unused(np.array([0.05, 0.1]))
    assert {k: [s.time for s in seen] for k, seen in unused.items()} == {
        0: [0.15]
    }


def test_of_too_many_the_latest_are_kept():
    rows = make_no_detections(2, 3)
    for i in range(1, 6):
        rows = _add(rows, 0.1 * i, box=0.1 * i)
    np.testing.assert_allclose(_stamps(rows, 0), [0.3, 0.4, 0.5])


@pytest.mark.parametrize(
    "now, stamp, fate",
    [
        pytest.param(1.0, 0.75, "used", id="just young enough"),
        pytest.param(1.0, 0.74, "too old", id="too old"),
        pytest.param(1.0, 1.0, "used", id="of now"),
        pytest.param(1.0, 1.0 + 1e-9, "used", id="of now but for rounding"),
        pytest.param(1.0, 1.1, "of the future", id="of the future"),
        pytest.param(1.0, np.nan, DETECTION_FATES[-1], id="without a time"),
        pytest.param(2.1, 2.1, DETECTION_FATES[-1], id="out of bounds"),
    ],
)
def test_only_what_can_be_used_is_kept_and_the_rest_is_counted(
    now, stamp, fate
):
    rows = make_no_detections(2, 3)
    for _ in range(3):  # It stays on the port, and is counted once.
        rows = _add(rows, now, box=stamp)
    assert _stamps(rows, 0) == ([stamp] if fate == "used" else [])
    counts = dict(zip(DETECTION_FATES, rows.detection_counts[0], strict=True))
    assert counts == {name: int(name == fate) for name in DETECTION_FATES}
    assert not rows.detection_counts[1].any()


def test_one_of_the_future_is_used_when_its_time_has_come():
    rows = _add(make_no_detections(2, 3), 1.0, box=1.1)
    assert rows.detection_counts[0].tolist() == [0, 0, 1, 0, 0]
    rows = _add(rows, 1.1, box=1.1)
    assert _stamps(rows, 0) == [1.1]
    assert rows.detection_counts[0].tolist() == [1, 0, 0, 0, 0]


def test_one_older_than_the_one_before_is_counted():
    rows = _add(make_no_detections(2, 3), 1.0, box=0.9)
    rows = _add(rows, 1.0, box=0.8)
    assert rows.detection_counts[0].tolist() == [1, 0, 0, 1, 0]


def test_the_rows_that_are_given_stay_as_they_are():
    rows = make_no_detections(2, 3)
    _add(rows, 0.1, box=0.1)
    for name, value in vars(make_no_detections(2, 3)).items():
        np.testing.assert_array_equal(getattr(rows, name), value)
