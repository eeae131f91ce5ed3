"""What the simulated detector makes of runs."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from recording_fixtures import make_planar_scene

from pbpf_drake.diagrams.detector.simulated_errors import (
    draw_errors,
    held_errors,
)
from pbpf_drake.log.log_records import DetectionRecord, PoseRecord
from pbpf_drake.truth.truth_simulation import RecordRun


def _record(poses: list[RigidTransform], times: np.ndarray) -> PoseRecord:
    return PoseRecord(
        times=times,
        q_WO=np.array([X.rotation().ToQuaternion().wxyz() for X in poses]),
        p_WO=np.array([X.translation() for X in poses]),
    )


def test_errors_are_those_of_the_last_detection_while_the_object_moves_on():
    scene = make_planar_scene()
    X_CW = scene.camera.pose().inverse()
    times = np.array([0.0, 10.0])
    truth = _record([RigidTransform(), RigidTransform([1.0, 0, 0])], times)
    turned = RigidTransform(RollPitchYaw(0, 0, 0.4), [0.0, 0.1, 0.0])
    detections = [
        DetectionRecord(name="block", time=t, received=t + 0.03, X_CO=X_CW @ X)
        for t, X in ((0.2, RigidTransform()), (5.0, turned))
    ]
    errors = held_errors(detections, truth, scene)
    updates = np.arange(0.16, 10.0, 0.16)[1:]  # From 0.23 s on.
    assert errors.shape == (len(updates), 2)
    later = updates >= 5.03
    np.testing.assert_allclose(errors[~later, 0], 0.1 * updates[~later])
    np.testing.assert_allclose(
        errors[later, 0], np.hypot(0.1 * updates[later], 0.1)
    )
    np.testing.assert_allclose(errors[:, 1], 0.4 * later, atol=1e-7)


def test_drawn_errors_are_a_function_of_the_seed_and_near_the_truth():
    scene = make_planar_scene(duration=0.5)
    recording = RecordRun(scene=scene)
    first, again, other = (
        draw_errors(recording, scene, seed)["block"] for seed in (0, 0, 1)
    )
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
    bias = scene.recording.detector.bias_position
    assert np.all(first[:, 0] > bias.min - 0.01)
    assert np.all(first[:, 0] < bias.max + 0.02)
