"""Detections of any release are read, and none is by luck."""

from mcap_ros2._dynamic import serialize_dynamic
import pytest

from pbpf_drake.bags.detection_layouts import DetectionLayouts, old_definition
from pbpf_drake.bags.read_limits import DEFAULT_LIMITS
from pbpf_drake.bags.ros2_messages import DETECTION_ARRAY, message_definition

POSE = {"pose": {"position": {"x": 0.3, "y": -0.2, "z": 0.9}}}


def detections(id_type, *, tracking, count=1, frame="camera"):
    """An array as a release before Humble has it, encoded."""
    text = old_definition(id_type, tracking=tracking)
    class_id = "cracker" if id_type == "string" else 7
    results = [{"id": class_id, "score": 0.8, "pose": POSE}]
    array = {
        "header": {"frame_id": frame},
        "detections": [{"results": results}] * count,
    }
    return serialize_dynamic(DETECTION_ARRAY, text)[DETECTION_ARRAY](array)


def new_detections():
    text = message_definition(DETECTION_ARRAY)
    result = {"hypothesis": {"class_id": "cracker", "score": 1.0}, "pose": POSE}
    return serialize_dynamic(DETECTION_ARRAY, text)[DETECTION_ARRAY](
        {"detections": [{"results": [result]}]}
    )


@pytest.mark.parametrize("id_type", ["string", "int64"])
@pytest.mark.parametrize("tracking", [True, False])
@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("frame", ["", "a", "camera", "camera_link"])
def test_old_layouts_are_found(id_type, tracking, count, frame):
    layouts = DetectionLayouts(DEFAULT_LIMITS)
    data = detections(id_type, tracking=tracking, count=count, frame=frame)
    found = layouts.Decode(data)
    assert len(found.detections) == count
    (result,) = found.detections[-1].results
    assert str(result.id) in ("cracker", "7")
    assert result.pose.pose.position.z == 0.9
    assert "only" in layouts.Sentence()


def test_nothing_is_said_of_todays_layout():
    layouts = DetectionLayouts(DEFAULT_LIMITS)
    (detection,) = layouts.Decode(new_detections()).detections
    assert detection.results[0].hypothesis.class_id == "cracker"
    assert layouts.Sentence() == ""


def test_an_array_without_detections_tells_nothing():
    layouts = DetectionLayouts(DEFAULT_LIMITS)
    empty = detections("string", tracking=True, count=0)
    assert layouts.Decode(empty).detections == []
    assert layouts.Sentence() == ""
    assert layouts.Decode(detections("string", tracking=True)).detections
    assert layouts.Decode(empty).detections == []


def test_once_a_layout_is_known_another_one_is_refused():
    layouts = DetectionLayouts(DEFAULT_LIMITS)
    layouts.Decode(detections("string", tracking=True))
    with pytest.raises(ValueError, match="no layout"):
        layouts.Decode(new_detections())


@pytest.mark.parametrize("cut", [4, 12, 20, 100])
def test_what_is_not_whole_fits_none(cut):
    layouts = DetectionLayouts(DEFAULT_LIMITS)
    with pytest.raises(ValueError, match="no layout"):
        layouts.Decode(detections("string", tracking=True)[:-cut])


def test_texts_that_can_not_be_read_fit_none():
    layouts = DetectionLayouts(DEFAULT_LIMITS)
    with pytest.raises(ValueError, match="no layout"):
        layouts.Decode(detections("string", tracking=True, frame="\1\2"))
