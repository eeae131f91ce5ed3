"""The filter outside of any simulation."""

from dataclasses import replace

from filter_fixtures import PERIOD, make_push_log, planar_scene, small_config
import numpy as np
import pytest

from pbpf_drake.diagrams.filter_in_station import MakeStation, StationDriver
from pbpf_drake.filtering.live_filter import LiveFilter

LOG = make_push_log(duration=1.0)


@pytest.fixture(scope="module")
def scene():
    scene = planar_scene()
    return replace(scene, filter=small_config(scene, seed=3))


def test_what_the_robot_did_in_periods_that_are_left_out_is_not_lost(scene):
    """The block is pushed by 48 mm while no update is made."""
    log = make_push_log(duration=3.0)
    many = replace(scene, filter=replace(scene.filter, num_particles=30))
    driver = StationDriver(MakeStation(many, log))
    live = LiveFilter(scene=many, start=driver.Read(0.0))
    for time in (*np.arange(1, 10) * PERIOD, 14 * PERIOD):
        (X_WO,) = live.Update(driver.Read(time))
    # The last detections are from before the gap: the physics did it.
    truth = log.ground_truth["block"]
    before, after = (
        np.interp(t * PERIOD, truth.times, truth.p_WO[:, 0]) for t in (9, 14)
    )
    assert after - before > 0.04
    assert X_WO.translation()[0] == pytest.approx(after, abs=0.015)


def test_a_late_loop_goes_on_with_the_next_whole_period(scene):
    start = StationDriver(MakeStation(scene, LOG)).Read(0.5)
    live = LiveFilter(scene=scene, start=start)
    for now, periods in ((0.5, 1), (0.55, 1), (0.66, 2), (0.7, 2), (1.31, 6)):
        expected = 0.5 + PERIOD * periods
        assert live.NextTime(now) == pytest.approx(expected)


def test_late_updates_of_a_live_loop_are_told(scene, caplog):
    fast = replace(scene, filter=replace(scene.filter, period=1e-5))
    driver = StationDriver(MakeStation(scene, LOG))
    live = LiveFilter(scene=fast, start=driver.Read(0.0))
    for time in 0.1, 0.2, 0.3:
        live.Update(driver.Read(time))
    assert live.late_updates.late == 3
    assert len(caplog.records) == 1
    assert "longer than the period" in caplog.text


def test_a_live_loop_may_be_late(scene):
    driver = StationDriver(MakeStation(scene, LOG))
    live = LiveFilter(scene=scene, start=driver.Read(0.0))
    for time in 0.17, 0.30, 0.55:
        (X_WO,) = live.Update(driver.Read(time))
        assert np.all(np.isfinite(X_WO.GetAsMatrix4()))
    truth = LOG.ground_truth["block"].p_WO[0]
    np.testing.assert_allclose(X_WO.translation(), truth, atol=0.04)


def test_a_clock_that_goes_back_is_refused(scene):
    driver = StationDriver(MakeStation(scene, LOG))
    live = LiveFilter(scene=scene, start=driver.Read(0.0))
    live.Update(driver.Read(2 * PERIOD))
    for time in (2 * PERIOD, PERIOD):
        reading = replace(driver.Read(3 * PERIOD), time=time)
        with pytest.raises(ValueError, match="a clock that never goes back"):
            live.Update(reading)


def test_all_that_the_ports_give_can_be_had(scene):
    driver = StationDriver(MakeStation(scene, LOG))
    live = LiveFilter(scene=scene, start=driver.Read(0.0))
    live.Update(driver.Read(PERIOD))
    assert live.Output("covariances").shape == (36,)
    assert live.Output("update_time") == [PERIOD]
    with pytest.raises(RuntimeError, match="no_such_port"):
        live.Output("no_such_port")
