import numpy as np
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.diagrams.benchmark.benchmark_workload import (
    WORKLOADS,
    LoadWorkload,
    cut_log,
    find_push,
)
from pbpf_drake.log.log_records import (
    DetectionRecord,
    JointRecord,
    Log,
    PoseRecord,
)


def _truth(begin: float, end: float) -> PoseRecord:
    """An object that is moved by 0.1 m/s between two times of 10 s."""
    times = np.arange(0.0, 10.0, 0.02)
    x = 0.1 * (np.clip(times, begin, end) - begin)
    q = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
    return PoseRecord(times, q, np.outer(x, [1.0, 0.0, 0.0]))


def test_a_push_is_while_all_objects_move():
    begin, end = find_push([_truth(2.0, 7.0), _truth(3.0, 8.0)])
    # 1 mm takes 10 ms, the truth has steps of 20 ms.
    assert begin == pytest.approx(3.01, abs=0.011)
    assert end == pytest.approx(6.99, abs=0.011)


def _detection(time: float, received: float) -> DetectionRecord:
    return DetectionRecord("box", time, received, RigidTransform())


def test_a_part_of_a_log_starts_at_time_zero_and_has_nothing_else():
    times = np.arange(0.0, 5.0, 0.5)
    log = Log(
        joints=JointRecord(("a",), times, times[:, None], 2 * times[:, None]),
        detections=(
            _detection(1.9, 2.2),
            _detection(2.0, 2.1),
            _detection(2.9, 3.1),
        ),
        start_time=1_000,
    )
    part = cut_log(log, 1.7, 3.0)
    np.testing.assert_allclose(part.joints.times, [0.0, 0.5, 1.0])
    np.testing.assert_allclose(part.joints.positions[:, 0], [2.0, 2.5, 3.0])
    np.testing.assert_allclose(part.joints.velocities[:, 0], [4.0, 5.0, 6.0])
    (detection,) = part.detections
    assert (detection.time, detection.received) == pytest.approx((0.0, 0.1))
    assert part.start_time == 2_000_001_000


@pytest.mark.parametrize("num_objects", WORKLOADS)
def test_workloads_are_long_pushes_of_objects_that_are_detected_first(
    num_objects,
):
    workload = LoadWorkload(num_objects)
    names = workload.scene.object_names()
    assert len(names) == num_objects
    assert workload.log.duration > 60 * workload.scene.filter.period
    assert workload.log.warnings == ()
    for name in names:
        times = [d.time for d in workload.log.detections if d.name == name]
        assert times[0] < 0.5 and times[10] < 1.0
    travel = np.ptp(workload.log.joints.positions, axis=0)
    assert np.max(travel) > 0.2
