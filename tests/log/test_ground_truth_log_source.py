from log_fixtures import make_small_log
import numpy as np
import pytest

from pbpf_drake.log.ground_truth_log_source import GroundTruthLogSource
from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.log.pose_interpolation import interpolate_poses


def _records():
    box = make_small_log().ground_truth["box"]
    can = PoseRecord(box.times, box.q_WO[::-1], box.p_WO + 1.0)
    return {"box": box, "can": can}


def test_poses_are_interpolated_in_the_order_of_the_names():
    records = _records()
    names = ["can", "box"]
    dut = GroundTruthLogSource(records=records, object_names=names)
    context = dut.CreateDefaultContext()
    for time in (-1.0, 0.0, 0.1234, 100.0):
        context.SetTime(time)
        poses = dut.GetOutputPort("ground_truth_poses").Eval(context)
        assert len(poses) == 2
        for name, X_WO in zip(names, poses, strict=True):
            q, p = interpolate_poses(records[name], np.array([time]))
            np.testing.assert_allclose(X_WO.translation(), p[0], atol=1e-15)
            found = X_WO.rotation().ToQuaternion().wxyz()
            assert abs(np.dot(found, q[0])) == pytest.approx(1, abs=1e-14)


def test_an_object_without_truth_is_refused_by_name():
    with pytest.raises(ValueError, match=r"\['mug'\].*\['box', 'can'\]"):
        GroundTruthLogSource(records=_records(), object_names=["box", "mug"])


def test_output_depends_on_time_only():
    dut = GroundTruthLogSource(records=_records(), object_names=["box"])
    assert not dut.HasAnyDirectFeedthrough()
