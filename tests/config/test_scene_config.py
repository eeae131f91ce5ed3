from filter_fixtures import PLANAR_SCENE, SCENES
import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
import pytest

from pbpf_drake.config.particle_filter_config import ParticleFilterConfig
from pbpf_drake.config.scene_config import LoadScene

DEGREES = "rotation: !Rpy {deg: [180.0, 0.0, 0.0]}"


def _load(tmp_path, *changes: tuple[str, str], more: str = ""):
    """Loads the planar pusher's scene with some of its text replaced."""
    text = PLANAR_SCENE
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = tmp_path / "my_scene.yaml"
    path.write_text(text + more)
    return LoadScene(path)


def test_a_scene_is_what_its_file_says(tmp_path):
    scene = _load(
        tmp_path,
        ("  block: {}", "  block: {class_id: steel, visibility: {penalty: 1}}"),
        ("fx: 605.904", "fx: 600"),
        more="filter: {num_particles: 12, seed: 5}\n"
        "topics: {detections: /seen, joint_names: {pusher_x: axis_1}}\n",
    )
    assert scene.robot == "pusher"
    assert scene.object_names() == ["block"]
    assert scene.object_by_class() == {"steel": "block"}
    assert scene.tracked["block"].visibility.penalty == 1
    assert scene.tracked["block"].visibility.high_weight == 0.75
    assert (scene.camera.fx, scene.camera.fy) == (600, 604.46)
    expected = RigidTransform(RollPitchYaw(np.pi, 0, 0), [0.37, 0.0, 1.0])
    assert scene.camera.pose().IsNearlyEqualTo(expected, 1e-12)
    assert scene.filter == ParticleFilterConfig(num_particles=12, seed=5)
    assert scene.topics.detections == "/seen"
    assert scene.topics.joint_states == "/joint_states"
    assert scene.topics.joint_names == {"pusher_x": "axis_1"}
    assert scene.path == str(tmp_path / "my_scene.yaml")


def test_without_a_class_the_detector_reports_the_models_name(tmp_path):
    assert _load(tmp_path).object_by_class() == {"block": "block"}


def test_a_scene_without_a_filter_has_the_papers(tmp_path):
    assert _load(tmp_path).filter == ParticleFilterConfig()


def test_objects_keep_the_order_of_the_file(tmp_path):
    more = "  zebra: {}\n  apple: {}\n"
    scene = _load(tmp_path, ("  block: {}\n", "  block: {}\n" + more))
    assert scene.object_names() == ["block", "zebra", "apple"]


@pytest.mark.parametrize("name", ["cheezit_1", "planar_push"])
def test_shipped_scenes_load_also_by_a_relative_name(name, monkeypatch):
    monkeypatch.chdir(SCENES)
    scene = LoadScene(f"{name}.yaml")
    assert scene.path == str(SCENES / f"{name}.yaml")


def test_a_file_that_is_missing_is_named(tmp_path):
    for path in (tmp_path / "none.yaml", tmp_path):
        with pytest.raises(FileNotFoundError, match=f"no scene file {path}"):
            LoadScene(path)


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("robot: pusher", "robots: pusher", r"robots: .*unknown to the schema"),
        ("fx: 605.904", "f: 605.904", r"camera\.f: .*unknown"),
        ("fx: 605.904", "fx: wide", r"camera\.fx: .*float: 'wide'"),
        ("fx: 605.904", "fx: -1", r"camera\.fx is -1.0; expected at least 0"),
        ("fx: 605.904", "fx: .inf", r"camera\.fx is inf; expected"),
        ("fy: 604.460", "fy: .nan", r"camera\.fy is nan; expected"),
        ("cx: 311.145", "cx: .nan", r"camera\.cx is nan; expected"),
        ("width: 640", "width: 0", r"camera\.width is 0; expected"),
        ("height: 480", "height: 4.5", r"camera\.height: "),
        (
            "[0.37, 0.0, 1.0]",
            "[.nan, 0, 0]",
            r"camera\.X_WC\.translation\[0\] in line \d+ is \.nan; expected ",
        ),
        (
            "[180.0, 0.0, 0.0]",
            "[0, .nan, 0]",
            r"camera\.X_WC\.rotation\.deg\[1\] in line \d+ is \.nan; expected ",
        ),
        (
            "width: 640",
            "width: 2000000000",
            r"camera\.width is 2000000000; .* at most 10,000",
        ),
        ("[0.37, 0.0, 1.0]", "[0, 0]", r"camera\.X_WC\.translation: "),
        (
            "[0.37, 0.0, 1.0]",
            "!UniformVector {min: [0, 0, 0], max: [1, 1, 1]}",
            r"camera\.X_WC is random",
        ),
        (
            "translation: [0.37, 0.0, 1.0]",
            "base_frame: table",
            r"camera\.X_WC\.base_frame is 'table'; expected none",
        ),
        ("robot: pusher", "robot: ''", r"robot is empty"),
        ("robot: pusher", "robot: [pusher]", r"robot: "),
        ("  block: {}", "  - block", r"tracked: "),
        ("  block: {}", "  block: big", r"tracked\.block: "),
        ("  block: {}", "  pusher: {}", r"tracked .*'pusher', .*is the robot"),
        (
            "  block: {}",
            "  block: {}\n  brick: {class_id: block}",
            r"tracked: .*same class_id.*\['block', 'block'\]",
        ),
        (
            "  block: {}",
            "  block: {visibility: {penalty: 2}}",
            r"tracked\.block\.visibility\.penalty is 2.0; expected in",
        ),
        (
            "  block: {}",
            "  block: {visibility: {height: 2}}",
            r"tracked\.block\.visibility\.height: ",
        ),
        ("- add_model:\n    name: table", "- x:\n    name: t", r"directives: "),
    ],
)
def test_what_is_wrong_is_named_with_file_and_field(
    tmp_path, old, new, message
):
    with pytest.raises(ValueError, match=r"my_scene\.yaml: " + message):
        _load(tmp_path, (old, new))


@pytest.mark.parametrize(
    "more, message",
    [
        ("filter: {particles: 3}", r"filter\.particles: .*unknown"),
        ("filter: {num_particles: 0}", r"filter\.num_particles is 0; expected"),
        ("filter: {num_particles: 1.5}", r"filter\.num_particles: "),
        ("filter: {period: fast}", r"filter\.period: .*'fast'"),
        ("filter: {process_noise: 0.1}", r"filter\.process_noise: "),
        (
            "filter: {physics: {mass: {min: 0}}}",
            r"filter\.physics\.mass\.min is 0.0; expected at least 1e-06",
        ),
        ("topics: {joint_names: [a]}", r"topics\.joint_names: "),
        ("recording: {duration: long}", r"recording\.duration: "),
        ("unknown: {}", r"unknown: "),
    ],
)
def test_what_is_wrong_further_on_is_named_as_well(tmp_path, more, message):
    with pytest.raises(ValueError, match=r"my_scene\.yaml: " + message):
        _load(tmp_path, more=more + "\n")


def test_a_scene_without_models_is_refused(tmp_path):
    start = PLANAR_SCENE[: PLANAR_SCENE.index("robot:")]
    with pytest.raises(ValueError, match="my_scene.yaml: directives is empty"):
        _load(tmp_path, (start, ""))


def test_a_scene_that_tracks_nothing_is_refused(tmp_path):
    tracked = PLANAR_SCENE[
        PLANAR_SCENE.index("tracked:") : PLANAR_SCENE.index("camera:")
    ]
    with pytest.raises(ValueError, match="my_scene.yaml: tracked is empty"):
        _load(tmp_path, (tracked, ""))


@pytest.mark.parametrize("text", ["", "- a\n- b\n", "{{{", "\0", "just text"])
def test_what_is_no_scene_at_all_is_refused_with_its_name(tmp_path, text):
    path = tmp_path / "my_scene.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"Scene file .*my_scene\.yaml: "):
        LoadScene(path)


def test_what_drake_says_of_a_file_is_in_one_line(tmp_path):
    more = "recording: {path: {<<: [1]}}\n"
    with pytest.raises(ValueError, match="expected a mapping") as error:
        _load(tmp_path, more=more)
    assert "\n" not in str(error.value)
