import numpy as np
import pytest
from recording_fixtures import make_planar_scene

from pbpf_drake.config.distributions import PoseStddev
from pbpf_drake.log.mcap_log_writer import WriteLog
from pbpf_drake.truth.truth_simulation import RecordRun


@pytest.fixture(scope="module")
def recording():
    return RecordRun(scene=make_planar_scene(duration=0.6))


def test_times_are_those_of_the_configured_periods(recording):
    log = recording.log
    np.testing.assert_allclose(log.joints.times, np.arange(61) * 0.01)
    truth = log.ground_truth["block"]
    np.testing.assert_allclose(truth.times, np.arange(31) * 0.02)
    np.testing.assert_allclose(recording.image_times, np.arange(10) * 0.066)
    received = [d.received - d.time for d in log.detections]
    np.testing.assert_allclose(received, 0.03, atol=1e-12)
    assert log.start_time > 0


def test_velocities_are_the_slopes_of_the_positions(recording):
    joints = recording.log.joints
    assert joints.names == ("pusher_x", "pusher_y")
    slopes = np.diff(joints.positions, axis=0) / 0.01
    middle = (joints.velocities[1:] + joints.velocities[:-1]) / 2
    assert np.abs(joints.velocities).max() > 0.05
    np.testing.assert_allclose(middle, slopes, atol=5e-3)


def test_truth_is_the_block_that_the_probe_pushes(recording):
    truth = recording.log.ground_truth["block"]
    np.testing.assert_allclose(truth.p_WO[0], [0.2, 0, 0.0065], atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(truth.q_WO, axis=1), 1)
    probe = np.interp(
        truth.times,
        recording.log.joints.times,
        recording.log.joints.positions[:, 0],
    )
    gap = truth.p_WO[:, 0] - probe
    assert truth.p_WO[-1, 0] > 0.24
    np.testing.assert_allclose(gap[-5:], 0.045 + 0.004745, atol=2e-4)


def test_a_visible_block_is_detected_near_its_true_pose(recording):
    assert recording.visibility.min() > 0.9
    scene, log = make_planar_scene(), recording.log
    assert len(log.detections) == len(recording.image_times)
    truth = log.ground_truth["block"]
    for detection in log.detections:
        p_WO = (scene.camera.pose() @ detection.X_CO).translation()
        true = [np.interp(detection.time, truth.times, x) for x in truth.p_WO.T]
        assert 0.02 < np.linalg.norm(p_WO - true) < 0.09


def _bytes(tmp_path, *, seed: int = 4, run: int = 0) -> bytes:
    scene = make_planar_scene(duration=0.3, seed=seed)
    log = RecordRun(scene=scene, run=run).log
    WriteLog(filename=tmp_path / "log.mcap", scene_topics=scene.topics, log=log)
    return (tmp_path / "log.mcap").read_bytes()


def test_a_run_is_a_function_of_scene_seed_and_number(tmp_path):
    first = _bytes(tmp_path)
    assert _bytes(tmp_path) == first
    assert _bytes(tmp_path, seed=5) != first
    assert _bytes(tmp_path, run=1) != first
    assert _bytes(tmp_path, run=1) == _bytes(tmp_path, run=1)


def test_runs_start_elsewhere():
    scene = make_planar_scene(duration=0.02)
    scene.recording.start_stddev = PoseStddev(position=0.01, rotation=0.1)
    starts = []
    for run in range(3):
        truth = RecordRun(scene=scene, run=run).log.ground_truth["block"]
        starts.append([*truth.p_WO[0], *truth.q_WO[0]])
    starts = np.array(starts)
    assert np.all(np.ptp(starts, axis=0)[[0, 1, 6]] > 1e-4)
    # The block still lies flat on the table.
    np.testing.assert_allclose(starts[:, 2], 0.0065, atol=1e-6)
    np.testing.assert_allclose(starts[:, [4, 5]], 0, atol=1e-4)


def test_a_run_without_a_number_is_refused():
    with pytest.raises(ValueError, match="run is -1; expected 0 or more"):
        RecordRun(scene=make_planar_scene(), run=-1)


def test_progress_reaches_the_end():
    times = []
    RecordRun(scene=make_planar_scene(duration=0.1), progress=times.append)
    assert times == sorted(times)
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(0.1)


def test_a_recording_that_fits_no_robot_names_the_scene():
    scene = make_planar_scene()
    scene.recording.stiffness = []
    with pytest.raises(ValueError, match="planar_push.yaml: recording.stiff"):
        RecordRun(scene=scene)
