"""Pushes that others recorded as ROS 1 bags, tracked from the bags."""

import numpy as np
from paths import DATA
from push_fixtures import num_columns, rows_of_methods
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.diagrams import evaluate_push_bags
from pbpf_drake.diagrams.evaluate_push_bags import (
    choose_blackout,
    contact_interval,
    evaluate,
    main,
    summarize,
)
from pbpf_drake.diagrams.jobs.scene_run import scene_path
from pbpf_drake.log.log_reader import ReadLog
from pbpf_drake.log.log_records import JointRecord, Log, PoseRecord
from pbpf_drake.poses.quaternions import angle_between

BAGS = DATA / "push_bags"
recorded = pytest.mark.skipif(not BAGS.is_dir(), reason="no recorded bags")


def _push() -> Log:
    """The probe touches a resting block from 1 s to 2 s."""
    times = np.linspace(0, 3, 301)
    x = np.interp(times, [0, 1, 2, 3], [-0.2, -0.0542, -0.0542, -0.3])
    return Log(
        joints=JointRecord(
            names=("pusher_x", "pusher_y"),
            times=times,
            positions=np.column_stack([x, 0 * x]),
        ),
        detections=(),
        ground_truth={
            "block": PoseRecord(
                times=np.array([0.0, 3.0]),
                q_WO=np.tile([1.0, 0, 0, 0], (2, 1)),
                p_WO=np.zeros((2, 3)),
            )
        },
    )


def test_contact_is_while_the_probe_is_beside_the_block():
    start, slip = contact_interval(_push(), "block")
    assert start == pytest.approx(1.0, abs=0.03)
    assert slip == pytest.approx(2.0, abs=0.03)


def test_blackouts_are_where_they_are_said_to_be():
    for slip in np.linspace(2.0, 2.3, 20):
        contact = choose_blackout("contact", slip, 0.16)
        earlier = choose_blackout("earlier", slip, 0.16)
        across = choose_blackout("slip", slip, 0.16)
        for start, end in (contact, earlier, across):
            assert end - start == pytest.approx(0.5)
        assert slip - 0.26 - 1e-9 <= contact[1] <= slip - 0.1
        assert earlier[1] == pytest.approx(contact[0])
        assert slip + 0.25 <= across[1] <= slip + 0.41 + 1e-9
        for _, end in (contact, across):
            assert end / 0.16 == pytest.approx(round(end / 0.16))


@recorded
@pytest.mark.parametrize("name", ["Test_st_1", "Test_st_4"])
def test_a_bag_is_read_as_it_is(name):
    scene = LoadScene(scene_path("planar_push_bag"))
    log = ReadLog(
        filename=BAGS / f"{name}.bag",
        scene=scene,
        joint_names=("pusher_x", "pusher_y"),
    )
    (warning,) = log.warnings
    assert "no detections" in warning
    assert log.duration == pytest.approx(6.0, abs=0.1)
    truth = log.ground_truth["block"]
    assert len(truth.times) > 590
    # The block lies on the table, turns by about 65 degrees, and rests then.
    np.testing.assert_allclose(truth.p_WO[:, 2], 0.0047, atol=0.0015)
    turn = angle_between(truth.q_WO[0], truth.q_WO[-1])
    assert turn == pytest.approx(np.deg2rad(65), abs=0.1)
    # The probe touches it: its axis is a radius from the side, but for some
    # millimeters of calibration and delay.
    start, slip = contact_interval(log, "block")
    assert 2.0 < start < 2.5 and 3.8 < slip < 4.5


@recorded
def test_the_block_is_followed_through_a_blackout_in_contact():
    rows = {
        method: evaluate((BAGS / "Test_st_4.bag", "earlier", 0, method))
        for method in ("pbpf", "dope")
    }
    assert rows["pbpf"]["moved_m"] > 0.05
    assert rows["pbpf"]["end_m"] < 0.5 * rows["dope"]["end_m"]


def test_a_table_has_a_column_for_every_title():
    rows = rows_of_methods(
        run="a",
        blackout="contact",
        seed=0,
        moved_m=0.05,
        end_m=0.01,
        end_rad=0.1,
        before_slip_m=0.01,
        after_slip_m=0.02,
    )
    line = summarize("a", "contact", rows)
    titles, _ = evaluate_push_bags._HEADER.split("\n")
    assert num_columns(line) == num_columns(titles)
    assert "| 1.00 | 0 % |" in line


def test_a_folder_without_bags_is_refused(tmp_path, capsys):
    assert main([str(tmp_path)]) == 1
    assert "no bags" in capsys.readouterr().err
