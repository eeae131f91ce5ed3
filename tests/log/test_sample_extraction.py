"""What messages say is found in all their types and layouts."""

from types import SimpleNamespace

from authors_fixtures import transform
from log_fixtures import has_warning, make_small_scene
from mcap_fixtures import DETECTIONS, pose
from pydrake.math import RigidTransform
import pytest

from pbpf_drake.bags.log_stream import RawMessage
from pbpf_drake.bags.ros2_messages import (
    DETECTION_ARRAY,
    JOINT_STATE,
    POSE_STAMPED,
    POSE_WITH_COVARIANCE_STAMPED,
    TF_MESSAGE,
    TRANSFORM_STAMPED,
    header_message,
    message_definition,
)
from pbpf_drake.log.sample_extraction import extract_joints, extract_poses

STAMP, LOG_TIME = 7_000_000_005, 8_000_000_000
HEADER = header_message(stamp=STAMP, frame_id="/camera")
POSE = pose([1, 0, 0, 0], [1, 2, 3])
TRANSFORM = transform(STAMP, "/camera", "/box", RigidTransform([1, 2, 3]))
RESULT = {
    "hypothesis": {"class_id": "box", "score": 1.0},
    "pose": {"pose": POSE},
}
# Only the header of the whole array counts.
DETECTION = {
    "header": header_message(stamp=1, frame_id="other"),
    "results": [RESULT],
}
DETECTIONS_MESSAGE = {"header": HEADER, "detections": [DETECTION]}


def _decoded(fields):
    """Returns an object with fields as attributes, as decoders do."""
    if isinstance(fields, dict):
        return SimpleNamespace(**{k: _decoded(v) for k, v in fields.items()})
    if isinstance(fields, list):
        return [_decoded(field) for field in fields]
    return fields


def _raw(kind):
    return RawMessage("/topic", kind, "cdr", "", LOG_TIME, b"")


@pytest.mark.parametrize(
    "kind, message, name",
    [
        (POSE_STAMPED, {"header": HEADER, "pose": POSE}, ""),
        (
            POSE_WITH_COVARIANCE_STAMPED,
            {"header": HEADER, "pose": {"pose": POSE}},
            "",
        ),
        (TRANSFORM_STAMPED, TRANSFORM, "box"),
        (TF_MESSAGE, {"transforms": [TRANSFORM]}, "box"),
        ("tf/tfMessage", {"transforms": [TRANSFORM]}, "box"),
        (DETECTION_ARRAY, DETECTIONS_MESSAGE, "box"),
        ("vision_msgs/Detection3DArray", DETECTIONS_MESSAGE, "box"),
    ],
)
def test_a_pose_is_the_same_in_every_type(kind, message, name):
    (sample,) = extract_poses(_raw(kind), _decoded(message))
    assert (sample.log_time, sample.stamp) == (LOG_TIME, STAMP)
    assert (sample.value.frame, sample.value.name) == ("camera", name)
    assert sample.value.q.tolist() == [1, 0, 0, 0]
    assert sample.value.p.tolist() == [1, 2, 3]


def test_every_transform_and_detection_is_one_sample():
    for kind, field, part in (
        (TF_MESSAGE, "transforms", TRANSFORM),
        (DETECTION_ARRAY, "detections", DETECTION),
    ):
        for count in (0, 3):
            message = _decoded({"header": HEADER, field: [part] * count})
            assert len(extract_poses(_raw(kind), message)) == count


def test_joints_are_what_the_message_says():
    message = {
        "header": HEADER,
        "name": ["a", "b"],
        "position": [0.5],
        "velocity": [],
    }
    sample = extract_joints(_raw(JOINT_STATE), _decoded(message))
    assert (sample.log_time, sample.stamp) == (LOG_TIME, STAMP)
    assert sample.value.names == ("a", "b")
    assert sample.value.positions == [0.5]
    assert sample.value.velocities == []


@pytest.mark.parametrize("fields", ["string id", "int64 id", "string class_id"])
def test_detections_of_older_layouts_are_read(faulty, fields):
    name = fields.split()[1]
    text = message_definition(DETECTION_ARRAY).replace(
        "vision_msgs/ObjectHypothesis hypothesis", f"{fields}\nfloat64 score"
    )
    faulty.define(DETECTION_ARRAY, text)
    scene = make_small_scene()
    scene.tracked["box"].class_id = "7"
    value = 7 if "int" in fields else "7"
    result = {
        name: value,
        "score": 0.5,
        "pose": {"pose": pose([1, 0, 0, 0], [1, 2, 3])},
    }
    faulty.joints(0.0)
    faulty.write(
        DETECTIONS,
        DETECTION_ARRAY,
        {"detections": [{"results": [result]}]},
        0.1,
    )
    (detection,) = faulty.read(scene).detections
    assert detection.X_CO.translation().tolist() == [1, 2, 3]


def test_the_hypothesis_with_the_highest_score_counts(faulty):
    faulty.joints(0.0)
    results = [
        {"hypothesis": {"class_id": name, "score": score}}
        for name, score in [("mug", 0.2), ("box", 0.7), ("pan", 0.1)]
    ]
    faulty.write(
        DETECTIONS,
        DETECTION_ARRAY,
        {"detections": [{"results": results}, {"results": []}]},
        0.1,
    )
    log = faulty.read()
    assert [d.name for d in log.detections] == ["box"]
    assert has_warning(log, "1 detection of the unknown class ''")
