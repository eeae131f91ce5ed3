"""Which poses can be used, and what is said of the others."""

import math

import numpy as np
import pytest

from pbpf_drake.bags.log_notes import LogNotes
from pbpf_drake.log.log_samples import PoseSample
from pbpf_drake.log.pose_checks import is_usable_pose, unit
from pbpf_drake.poses.quaternions import angle_between


@pytest.mark.parametrize("length, warned", [(1.05, 0), (0.95, 0), (3.0, 1)])
def test_a_quaternion_is_normalized(faulty, length, warned):
    q = length * np.array([0.5, -0.5, 0.5, 0.5])
    faulty.joints(0.0)
    faulty.detection(0.1, q=q)
    faulty.truth(0.1, q=q)
    log = faulty.read()
    expected = np.array([0.5, -0.5, 0.5, 0.5])
    found = log.detections[0].X_CO.rotation().ToQuaternion().wxyz()
    assert angle_between(found, expected) < 1e-14
    np.testing.assert_allclose(
        log.ground_truth["box"].q_WO[0], expected, atol=1e-15
    )
    assert len(log.warnings) == 2 * warned


@pytest.mark.parametrize(
    "q, p, said",
    [
        ((1, 0, 0, 0), (1, 2, 3), None),
        ((0, 0, 0, 0), (1, 2, 3), "left out 1 pose whose quaternion is zero"),
        ((1, 0, 0, math.nan), (1, 2, 3), "whose quaternion is not finite"),
        ((1, 0, 0, 0), (1, math.inf, 3), "whose position is not finite"),
        ((2, 0, 0, 0), (1, 2, 3), "normalized 1 pose"),
        # Its squares are more than a double can hold.
        ((1e200, 0, 0, 0), (1, 2, 3), "normalized 1 pose"),
    ],
)
def test_what_is_wrong_with_a_pose_is_counted(q, p, said):
    notes = LogNotes()
    pose = PoseSample("frame", "box", np.array(q), np.array(p))
    usable = is_usable_pose(pose, notes.On("/seen", "pose"))
    assert usable == (said is None or said.startswith("normalized"))
    assert len(notes.Sentences()) == (said is not None)
    assert all(said in sentence for sentence in notes.Sentences())


def test_a_unit_quaternion_is_kept_to_the_bit():
    # The squares of its numbers don't add up to exactly 1.
    q = np.array([0.1, 0.7, 0.1, 0.7])
    q /= np.sqrt(np.sum(q * q))
    assert unit(q) is q
    np.testing.assert_allclose(unit(3 * q), q, atol=1e-15)
