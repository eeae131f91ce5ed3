from filter_fixtures import PLANAR_SCENE
import pytest

from pbpf_drake.config.log_topics import (
    PRESETS,
    LogTopics,
    frame_name,
    is_frame,
)
from pbpf_drake.config.scene_config import LoadScene


def _load(tmp_path, topics):
    path = tmp_path / "scene.yaml"
    path.write_text(f"{PLANAR_SCENE}topics: {topics}\n")
    return LoadScene(path).topics


@pytest.mark.parametrize("name", PRESETS)
def test_presets_are_valid_and_known_by_their_name(tmp_path, name):
    preset = PRESETS[name]()
    preset.ValidateOrThrow()
    assert preset.preset == name
    loaded = _load(tmp_path, f"{{preset: {name}}}")
    assert repr(loaded) == repr(preset)


def test_what_a_scene_gives_goes_before_its_preset(tmp_path):
    topics = _load(
        tmp_path,
        "{preset: authors, joint_states: /arm, X_WR: {translation: [0, 0, 1]}}",
    )
    assert topics.joint_states == "/arm"
    assert topics.detections == "tf:{name}"
    assert topics.ReferencePose().translation().tolist() == [0, 0, 1]


def test_joints_may_be_on_several_topics_or_fixed(tmp_path):
    topics = _load(
        tmp_path,
        "{joint_states: /arm, more_joint_states: [/hand, /arm, /head], "
        "fixed_joints: {pan: 0.5}}",
    )
    assert topics.joint_topics() == ("/arm", "/hand", "/head")
    assert topics.fixed_joints == {"pan": 0.5}


def test_without_a_preset_topics_are_ours(tmp_path):
    assert repr(_load(tmp_path, "{}")) == repr(LogTopics())


@pytest.mark.parametrize(
    "topics, message",
    [
        ("{preset: mine}", r"topics\.preset is 'mine'; expected one of"),
        ("{detections: ''}", r"topics\.detections is ''; expected a whole"),
        ("{ground_truth: /truth/}", r"topics\.ground_truth is '/truth/'"),
        ("{images: ''}", r"topics\.images is ''; expected a whole"),
        ("{images: 'tf:eye'}", r"images is 'tf:eye'; expected a topic"),
        (
            "{more_joint_states: [/hand, 'tf:tip']}",
            r"more_joint_states is 'tf:tip'; expected a topic",
        ),
        ("{more_joint_states: ['']}", r"topics\.more_joint_states is ''; exp"),
        (
            "{fixed_joints: {elbow: .nan}}",
            r"topics\.fixed_joints\.elbow is nan; expected a finite position",
        ),
        ("{joint_states: 'tf:arm'}", r"joint_states is 'tf:arm'; expected a"),
        ("{detections: 'tf:box'}", r"detections .* reference_frame is empty"),
        ("{tf_joints: {x: tip.x}}", r"tf_joints .* reference_frame is empty"),
        (
            "{reference_frame: w, tf_joints: {x: tip}}",
            r"tf_joints\.x is 'tip'; expected a frame and an axis",
        ),
        (
            "{reference_frame: w, tf_joints: {x: tip.w}}",
            r"tf_joints\.x is 'tip\.w'",
        ),
        (
            "{X_WR: {translation: [.nan, 0, 0]}}",
            r"topics\.X_WR\.translation\[0\] in line \d+ is \.nan; expected ",
        ),
        (
            "{X_WR: {base_frame: table}}",
            r"topics\.X_WR.base_frame is .table.; expected none",
        ),
    ],
)
def test_what_can_not_be_is_refused(tmp_path, topics, message):
    with pytest.raises(ValueError, match=message):
        _load(tmp_path, topics)


def test_frames_are_told_from_topics():
    assert is_frame("tf:/cracker") and not is_frame("/tf/cracker")
    assert frame_name("tf:/cracker") == frame_name("/cracker") == "cracker"
