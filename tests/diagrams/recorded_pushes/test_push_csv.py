from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
import pytest

from pbpf_drake.diagrams.recorded_pushes.push_csv import (
    MakeDetections,
    planar_poses,
    read_rows,
    stack_columns,
)
from pbpf_drake.poses.pose_conversion import pose_array

NAMES = ("t", "x", "y")
TEXT = "t,x,y\n0.5,1,2\n0.75,3,-4e-1\n"


def _write(folder: Path, text: str) -> Path:
    path = folder / "push.csv"
    path.write_text(text)
    return path


def test_columns_are_what_the_file_says_in_the_order_asked_for(tmp_path):
    rows = read_rows(_write(tmp_path, TEXT), NAMES)
    np.testing.assert_array_equal(rows["t"], [0.5, 0.75])
    np.testing.assert_array_equal(
        stack_columns(rows, ("y", "x")), [[2, 1], [-0.4, 3]]
    )


def test_columns_may_be_in_any_order_and_beside_others(tmp_path):
    text = "note,y,t,x\nfirst,2,0.5,1\n,-0.4,0.75,3\n"
    dut = stack_columns(read_rows(_write(tmp_path, text), NAMES), NAMES)
    np.testing.assert_array_equal(dut, [[0.5, 1, 2], [0.75, 3, -0.4]])


def test_one_row_is_enough(tmp_path):
    rows = read_rows(_write(tmp_path, "t,x,y\n0.5,1,2\n"), NAMES)
    assert rows.shape == (1,)
    np.testing.assert_array_equal(stack_columns(rows, NAMES), [[0.5, 1, 2]])


def test_all_columns_that_are_missing_are_named(tmp_path):
    path = _write(tmp_path, TEXT)
    with pytest.raises(
        ValueError, match=r"push\.csv has no columns \['b', 'a'"
    ):
        read_rows(path, ["b", "t", "a"])


def test_a_file_that_is_missing_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"none\.csv"):
        read_rows(tmp_path / "none.csv", NAMES)


@pytest.mark.filterwarnings("ignore:.*Empty input file")
@pytest.mark.parametrize("text", ["", "\n", "t,x,y\n0.5,1\n", "t,x\n1,2,3\n"])
def test_what_is_no_table_is_named(tmp_path, text):
    with pytest.raises(ValueError, match=r"push\.csv is no table with names"):
        read_rows(_write(tmp_path, text), NAMES)


def test_a_file_without_rows_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"push\.csv has no rows"):
        read_rows(_write(tmp_path, "t,x,y\n"), NAMES)


@pytest.mark.parametrize("value", ["x3", "", "nan", "inf"])
def test_a_file_with_what_is_no_number_is_named(tmp_path, value):
    path = _write(tmp_path, TEXT.replace("3", value))
    with pytest.raises(ValueError, match=r"push\.csv .*without a number"):
        read_rows(path, NAMES)


def _X_WO(x, y, theta, z) -> RigidTransform:
    return RigidTransform(RollPitchYaw(0, 0, theta), [x, y, z])


def test_an_object_on_a_table_turns_about_the_vertical_and_keeps_its_height():
    poses = np.array([[0.1, -0.2, 0.3], [0.4, 0.5, -2.0], [0.0, 0.0, 9.0]])
    times = np.array([0.0, 0.1, 0.3])
    dut = planar_poses(times, poses, 0.05)
    np.testing.assert_array_equal(dut.times, times)
    for i, pose in enumerate(poses):
        expected = pose_array(_X_WO(*pose, 0.05))
        np.testing.assert_array_equal(dut.p_WO[i], expected[4:])
        # q and -q are the same rotation.
        assert abs(dut.q_WO[i] @ expected[:4]) == pytest.approx(1, abs=1e-14)
        assert np.linalg.norm(dut.q_WO[i]) == pytest.approx(1, abs=1e-14)


def test_an_object_that_was_never_seen_has_no_poses():
    dut = planar_poses(np.empty(0), np.empty((0, 3)), 0.05)
    assert dut.q_WO.shape == (0, 4) and dut.p_WO.shape == (0, 3)


def test_detections_are_the_poses_as_the_camera_sees_them():
    X_WC = RigidTransform(RollPitchYaw(np.pi, 0.1, 0.2), [0.4, -0.1, 1.0])
    poses = [_X_WO(0.1, -0.2, 0.3, 0.05), _X_WO(0.4, 0.5, -2.0, 0.05)]
    detections = MakeDetections(
        object_name="brick",
        times=np.array([0.2, 0.7]),
        poses=[pose_array(X_WO) for X_WO in poses],
        X_WC=X_WC,
    )
    assert [d.time for d in detections] == [0.2, 0.7]
    assert [d.received for d in detections] == [0.2, 0.7]
    assert {d.name for d in detections} == {"brick"}
    for detection, X_WO in zip(detections, poses, strict=True):
        assert (X_WC @ detection.X_CO).IsNearlyEqualTo(X_WO, 1e-14)
