"""Messages whose type the file doesn't name."""

from mcap_ros2._dynamic import serialize_dynamic
import pytest

from pbpf_drake.bags.read_limits import DEFAULT_LIMITS
from pbpf_drake.bags.ros2_messages import (
    DETECTION_ARRAY,
    IMAGE,
    JOINT_STATE,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    TF_MESSAGE,
    TRANSFORM_STAMPED,
    message_definition,
)
from pbpf_drake.bags.type_guess import TypeGuess

HEADER = {"stamp": {"sec": 5, "nanosec": 7}, "frame_id": "world"}
MESSAGES = {
    JOINT_STATE: {"header": HEADER, "name": ["a"], "position": [0.1]},
    POSE_STAMPED: {"header": HEADER},
    POSE_WITH_COVARIANCE_STAMPED: {"header": HEADER},
    TRANSFORM_STAMPED: {"header": HEADER, "child_frame_id": "box"},
    TF_MESSAGE: {"transforms": [{"header": HEADER, "child_frame_id": "b"}]},
    DETECTION_ARRAY: {"header": HEADER, "detections": [{"header": HEADER}]},
    IMAGE: {"header": HEADER, "height": 1, "width": 2, "data": b"abcdef"},
}


def _encoded(kind):
    encode = serialize_dynamic(kind, message_definition(kind))[kind]
    return encode(MESSAGES[kind])


@pytest.mark.parametrize("kind", MESSAGES)
def test_a_message_is_of_the_type_that_it_fits(kind):
    guess = TypeGuess(DEFAULT_LIMITS)
    assert guess.Look(_encoded(kind)) == kind
    assert guess.type == kind and kind in guess.Sentence()
    # What is known isn't changed by a message that is damaged.
    assert guess.Look(b"\0\1") == kind


def test_what_fits_no_type_has_none():
    guess = TypeGuess(DEFAULT_LIMITS)
    for _ in range(100):
        assert guess.Look(b"\0\1\0\0\7\0\0\0text...") == ""
