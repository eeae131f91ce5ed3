import numpy as np
import pytest

from pbpf_drake.log.joint_log_source import JointLogSource, interpolate_joints
from pbpf_drake.log.log_records import JointRecord


def _record(velocities=None):
    return JointRecord(
        names=("a", "b"),
        times=np.array([0.0, 1.0, 3.0]),
        positions=np.array([[0.0, 10.0], [2.0, 10.0], [2.0, 6.0]]),
        velocities=velocities,
    )


@pytest.mark.parametrize(
    "time, q, v",
    [
        (-1.0, [0, 10], [0, 0]),
        (0.0, [0, 10], [2, 0]),
        (0.25, [0.5, 10], [2, 0]),
        (1.0, [2, 10], [0, -2]),
        (2.5, [2, 7], [0, -2]),
        (3.0, [2, 6], [0, -2]),
        (3.1, [2, 6], [0, 0]),
    ],
)
def test_positions_and_slopes(time, q, v):
    dut = JointLogSource(record=_record())
    context = dut.CreateDefaultContext()
    context.SetTime(time)
    found = dut.GetOutputPort("joint_positions").Eval(context)
    np.testing.assert_allclose(found, q, atol=1e-15)
    found = dut.GetOutputPort("joint_velocities").Eval(context)
    np.testing.assert_allclose(found, v, atol=1e-15)


def test_recorded_velocities_are_interpolated():
    velocities = np.array([[1.0, 0.0], [3.0, -1.0], [5.0, -3.0]])
    record = _record(velocities)
    _, v = interpolate_joints(record, 2.0)
    np.testing.assert_allclose(v, [4.0, -2.0])
    _, v = interpolate_joints(record, 3.0)
    np.testing.assert_allclose(v, [5.0, -3.0])
    _, v = interpolate_joints(record, 3.0001)
    np.testing.assert_allclose(v, [0.0, 0.0])


def test_one_sample_is_held_at_rest():
    record = JointRecord(("a",), np.zeros(1), np.array([[0.7]]))
    for time in (-1.0, 0.0, 1.0):
        q, v = interpolate_joints(record, time)
        assert (q[0], v[0]) == (0.7, 0.0)


def test_slopes_agree_with_numpy_interpolation():
    rng = np.random.default_rng(1)
    record = JointRecord(
        ("a",), np.cumsum(rng.uniform(0.01, 1, 20)), rng.normal(size=(20, 1))
    )
    for time in rng.uniform(record.times[0], record.times[-1], 50):
        q, v = interpolate_joints(record, time)
        steps = np.array([time - 1e-7, time, time + 1e-7])
        low, here, high = np.interp(steps, record.times, record.positions[:, 0])
        assert q[0] == pytest.approx(here, abs=1e-14)
        assert v[0] == pytest.approx((high - low) / 2e-7, rel=1e-5, abs=1e-6)


def test_outputs_depend_on_time_only():
    dut = JointLogSource(record=_record())
    assert not dut.HasAnyDirectFeedthrough()
    assert dut.num_input_ports() == 0
