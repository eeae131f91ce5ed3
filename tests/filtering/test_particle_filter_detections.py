"""What the filter does with detections that are late, damaged or impossible."""

from filter_fixtures import (
    BLOCK,
    PERIOD,
    FilterRun,
    assert_same,
    detections,
    planar_scene,
    run_tracking,
    small_config,
)
import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
import pytest

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.dope_measurement import Detection, DopeMeasurement

AWAY = [0.4, 0.1, 0.0065]
# No test here depends on the motion model; this is the faster one.
MOTION = {"motion": "constant_velocity"}


@pytest.fixture(scope="module")
def scene():
    return planar_scene()


def _make(scene, **changes) -> FilterRun:
    return FilterRun(scene, small_config(scene, **MOTION, **changes))


@pytest.mark.parametrize(
    "measurement, is_counted",
    [
        pytest.param(
            detections(0.3, block=[np.nan, 0, 0]), True, id="NaN position"
        ),
        pytest.param(
            detections(0.3, block=[np.inf, 0, 0]), True, id="infinite"
        ),
        pytest.param(
            detections(0.3, block=[0, 1e200, 0]), True, id="out of range"
        ),
        pytest.param(
            DopeMeasurement(
                {
                    "block": Detection(
                        RigidTransform(
                            RotationMatrix(np.full((3, 3), np.nan)), BLOCK
                        ),
                        0.3,
                    )
                }
            ),
            True,
            id="NaN rotation",
        ),
        pytest.param(detections(np.nan, block=AWAY), True, id="NaN stamp"),
        pytest.param(detections(np.inf, block=AWAY), True, id="infinite stamp"),
        pytest.param(
            detections(0.05, block=AWAY), True, id="older than the last"
        ),
        pytest.param(
            detections(0.1, block=AWAY), False, id="as old as the last"
        ),
        pytest.param(detections(0.0, block=AWAY), True, id="stale"),
        pytest.param(detections(-1e9, block=AWAY), True, id="long ago"),
        pytest.param(detections(0.45, block=AWAY), True, id="of the future"),
        pytest.param(detections(1e9, block=AWAY), True, id="of the far future"),
        pytest.param(
            detections(0.3, other=AWAY), False, id="of something else"
        ),
        pytest.param(DopeMeasurement(), False, id="empty"),
    ],
)
def test_a_detection_that_is_of_no_use_is_ignored(
    scene, measurement, is_counted
):
    run, other = (run_tracking(scene, **MOTION) for _ in range(2))
    run.measure(measurement)
    for i in (2, 3):
        if i == 3:  # It must not stand in the way of the next.
            for each in (run, other):
                each.measure(detections(0.47, block=BLOCK))
        for each in (run, other):
            each.update(i)
        assert run["detected"] == [i == 3]
    ports, expected = run.ports(), other.ports()
    # What was left out is counted.
    left_out = ports.pop("detection_counts") - expected.pop("detection_counts")
    assert left_out.sum() == int(is_counted)
    assert_same(ports, expected)


def test_a_stamp_of_the_future_is_used_when_its_time_has_come(scene):
    run = run_tracking(scene, **MOTION)
    run.measure(detections(2.1 * PERIOD, block=BLOCK))
    run.update(2)
    assert run["detected"] == [0]
    run.update(3)
    assert run["detected"] == [1]


@pytest.mark.parametrize("bad", [{"block": BLOCK}, [BLOCK], RigidTransform])
def test_a_measurement_of_another_type_is_a_worded_error(scene, bad):
    run = _make(scene)
    run.measure(bad)
    with pytest.raises(
        TypeError, match=f"dope_measurement.*{type(bad).__name__}.*expected"
    ):
        run.update(1)


def _estimate_with(scene, position, *, stamp, received) -> np.ndarray:
    """Where the block is said to be after one detection too many.

    The particles are spread over 5 mm and move along x by 0.1 m/s.
    """
    run = _make(
        scene,
        num_particles=400,
        initial_noise=PoseStddev(position=0.02),
        process_noise=PoseStddev(position=0.005),
        detection_noise=PoseStddev(position=0.005, rotation=0.1),
    )
    for i in (1, 2, 3, 4):
        time = i * PERIOD
        run.measure(detections(time, block=[0.1 * time, 0, 0.0065]))
        run.update(i)
    # Between two samples that are in the same period.
    run.simulator.AdvanceTo(received)
    run.measure(detections(stamp, block=position))
    run.update(int(received / PERIOD) + 1)
    return run["estimated_poses"][0, 4:6], run["detected"][0]


def test_a_late_detection_is_used_at_its_stamp(scene):
    """It says where the object was then, not where it is now."""
    stamp, received = 4.1 * PERIOD, 4.9 * PERIOD
    seen_then = [0.1 * stamp, 0.0, 0.0065]
    estimate, detected = _estimate_with(
        scene, seen_then, stamp=stamp, received=received
    )
    assert detected
    assert estimate[0] == pytest.approx(0.1 * 5 * PERIOD, abs=0.004)
    # The same position with the stamp of now is behind what is expected.
    behind, _ = _estimate_with(
        scene, seen_then, stamp=received, received=received
    )
    assert behind[0] < estimate[0] - 0.004


def test_a_detection_that_is_too_old_when_it_arrives_is_not_used(scene):
    for age, detected in ((0.24, True), (0.27, False)):
        run = _make(scene, max_detection_age=0.25)
        run.simulator.AdvanceTo(2.9 * PERIOD)
        # It is seen with the next sample, at the end of the period.
        run.measure(detections(3 * PERIOD - age, block=BLOCK))
        run.update(3)
        assert run["detected"] == [detected]


def test_several_detections_of_a_period_are_all_used(scene):
    """Their mean, if they are equally good."""
    run = _make(
        scene,
        num_particles=300,
        initial_noise=PoseStddev(position=0.05),
        process_noise=PoseStddev(),
        detection_noise=PoseStddev(position=0.005, rotation=0.1),
    )
    for i, x in enumerate((0.20, 0.21, 0.23)):
        run.simulator.AdvanceTo((0.2 + 0.25 * i) * PERIOD)
        time = run.context.get_time()
        run.measure(detections(time, block=[x, 0, 0.0065]))
    run.update(1)
    x = run["estimated_poses"][0, 4]
    assert x == pytest.approx(0.64 / 3, abs=0.002)


def test_what_is_far_from_the_scene_is_not_believed(scene):
    run = _make(scene)
    run.measure(detections(0.1, block=[0.2, 0.0, -5.0]))
    run.update(1)
    assert run["tracked"] == [0]
    assert run["detection_counts"].tolist() == [0, 0, 0, 0, 1]


@pytest.mark.parametrize(
    "detection, path, kind",
    [
        (Detection(None, 0.1), "X_WO", "NoneType"),
        (Detection(RigidTransform(), "0.1"), "time", "str"),
        (None, "", "NoneType"),
    ],
)
def test_a_detection_of_the_wrong_type_is_named(scene, detection, path, kind):
    run = _make(scene)
    run.measure(DopeMeasurement({"block": detection}))
    with pytest.raises(
        TypeError,
        match=rf"dope_measurement\.detections\['block'\]\.?{path} is a {kind}",
    ):
        run.update(1)
