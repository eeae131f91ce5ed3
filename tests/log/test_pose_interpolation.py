import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from pbpf_drake.log.log_records import PoseRecord
from pbpf_drake.log.pose_interpolation import find_segments, interpolate_poses
from pbpf_drake.poses.quaternions import angle_between


def _record(count=6, seed=0):
    rng = np.random.default_rng(seed)
    return PoseRecord(
        times=np.cumsum(rng.uniform(0.1, 1.0, count)),
        q_WO=Rotation.random(count, rng=rng).as_quat(scalar_first=True),
        p_WO=rng.normal(size=(count, 3)),
    )


def test_agrees_with_scipy_between_samples():
    record = _record()
    times = np.linspace(record.times[0], record.times[-1], 101)
    q, p = interpolate_poses(record, times)
    slerp = Slerp(
        record.times, Rotation.from_quat(record.q_WO, scalar_first=True)
    )
    expected = slerp(times).as_quat(scalar_first=True)
    assert angle_between(q, expected).max() < 1e-12
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1, atol=1e-15)
    for axis in range(3):
        np.testing.assert_allclose(
            p[:, axis],
            np.interp(times, record.times, record.p_WO[:, axis]),
            atol=1e-14,
        )


def test_samples_are_met():
    record = _record()
    q, p = interpolate_poses(record, record.times)
    assert angle_between(q, record.q_WO).max() < 1e-12
    np.testing.assert_allclose(p, record.p_WO, atol=1e-15)


def test_rests_before_and_after_the_record():
    record = _record()
    q, p = interpolate_poses(record, np.array([-1e9, 1e9]))
    np.testing.assert_array_equal(p, record.p_WO[[0, -1]])
    assert angle_between(q, record.q_WO[[0, -1]]).max() < 1e-12


def test_one_sample_rests_there():
    record = _record(count=1)
    q, p = interpolate_poses(record, np.array([-1.0, record.times[0], 5.0]))
    np.testing.assert_array_equal(p, np.tile(record.p_WO, (3, 1)))
    assert angle_between(q, record.q_WO).max() < 1e-12


def test_the_sign_of_a_quaternion_does_not_matter():
    record = _record()
    signs = np.array([1, -1, 1, 1, -1, -1.0])[:, None]
    flipped = PoseRecord(record.times, signs * record.q_WO, record.p_WO)
    times = np.linspace(0, record.times[-1], 50)
    q, _ = interpolate_poses(record, times)
    q_flipped, _ = interpolate_poses(flipped, times)
    assert angle_between(q, q_flipped).max() < 1e-12


def test_segments_of_a_hand_made_case():
    i, j, u = find_segments(
        np.array([1.0, 2.0, 4.0]), np.array([0.0, 1.0, 2.0, 3.0, 4.0, 9.0])
    )
    assert i.tolist() == [0, 0, 1, 1, 1, 1]
    assert j.tolist() == [1, 1, 2, 2, 2, 2]
    assert u.tolist() == [0, 0, 0, 0.5, 1, 1]
