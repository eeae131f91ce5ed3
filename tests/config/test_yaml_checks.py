import os
import threading

from filter_fixtures import PLANAR_SCENE
import pytest

from pbpf_drake.config.scene_config import LoadScene
from pbpf_drake.config.yaml_checks import (
    CheckYamlFile,
    RequireRegularFile,
    check_yaml,
)


def test_plain_yaml_is_accepted():
    check_yaml(b"")
    check_yaml(b"a: {x: 1}\nb: {x: 1}\nc: !Rpy {deg: [1, 2, 3]}\n")
    check_yaml(b"a: &a {x: 1}\nb: *a\nc: [*a, *a]\n")


def _refused(text: str) -> str:
    with pytest.raises(ValueError) as error:
        check_yaml(text.encode())
    message = str(error.value)
    assert "\n" not in message and len(message) < 400
    return message


@pytest.mark.parametrize(
    "text, name",
    [
        ("a: 1\nb: 2\na: 3\n", "a"),
        ("x:\n  y: {b: 1,\n b: 2}\n", "x.y.b"),
        ("- {x: 1}\n- - x: 1\n    x: 1\n", "[1][0].x"),
        ("a: &r {<<: {x: 1}, <<: {x: 2}}\n", "a.<<"),
        ("'a': 1\na: 2\n", "a"),
    ],
)
def test_a_key_that_is_given_twice_is_named_with_both_lines(text, name):
    message = _refused(text)
    assert message.startswith(f"{name} is given more than once, in line ")
    assert message.count("line ") == 2


@pytest.mark.parametrize(
    "text, name",
    [
        ("a: &r {b: *r}\n", "a.b"),
        ("a: &r [1, *r]\n", "a[1]"),
        ("a: &r {b: &s {c: *r}}\n", "a.b.c"),
        ("&r {b: *r}\n", "b"),
    ],
)
def test_an_anchor_that_contains_itself_is_named(text, name):
    assert _refused(text).startswith(f"{name} contains itself")


@pytest.mark.parametrize("start, end", [("[", "]"), ("{a: ", "}"), ("- ", "")])
def test_deep_nesting_is_refused_without_following_it(start, end):
    depth = 100_000
    message = _refused(start * depth + "1" + end * depth)
    assert "line 1 is nested more deeply than 50 levels" in message


def test_anchors_that_multiply_each_other_are_refused():
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    for i in range(1, 12):
        lines.append(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]")
    assert "has more than 100,000 values" in _refused("\n".join(lines))


def test_anchors_that_nest_each_other_are_refused():
    lines = ["a0: &a0 [1]"]
    lines += [f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, 3000)]
    assert "levels" in _refused("\n".join(lines))


@pytest.mark.parametrize("text", ["{{{", "\0", "a: *none", "a: 1\n---\nb: 2"])
def test_what_is_no_yaml_is_one_sentence(text):
    assert "YAML" in _refused(text)


@pytest.mark.parametrize(
    "number", [".nan", "-.inf", "1.0e+200", "123456789012", "0x" + "f" * 300]
)
def test_a_number_in_directives_is_one_that_can_be(number):
    text = "directives:\n- add_weld: {X_PC: {translation: [0, %s, 0]}}\n"
    name = r"directives[0].add_weld.X_PC.translation[1] in line 2 is "
    message = _refused(text % number)
    assert message.startswith(name + number[:60])
    assert "expected a number from -1,000,000 to 1,000,000" in message


def test_a_large_file_is_refused_without_reading_it(tmp_path):
    path = tmp_path / "large.yaml"
    with path.open("wb") as file:
        file.truncate(20_000_000_000)
    with pytest.raises(ValueError, match="20,000,000,000 bytes; .* 10,000,000"):
        CheckYamlFile(path)


def test_a_pipe_is_refused_without_waiting_for_it(tmp_path):
    path = tmp_path / "scene.yaml"
    os.mkfifo(path)
    for check in RequireRegularFile, CheckYamlFile, LoadScene:
        with pytest.raises(ValueError, match=f"{path} is no regular file"):
            check(path)
    RequireRegularFile(tmp_path / "none.yaml")


@pytest.mark.parametrize(
    "more, message",
    [
        ("filter: {seed: 1}\nfilter: {seed: 2}\n", "filter is given more than"),
        ("recording: &r {path: *r}\n", "recording.path contains itself"),
        ("recording: " + "[" * 3000 + "]" * 3000, "nested more deeply"),
    ],
)
def test_a_scene_file_is_checked_before_it_is_read(tmp_path, more, message):
    path = tmp_path / "my_scene.yaml"
    path.write_text(PLANAR_SCENE + more)
    errors = []

    def load():
        try:
            LoadScene(path)
        except ValueError as error:
            errors.append(str(error))

    thread = threading.Thread(target=load, daemon=True)
    thread.start()
    thread.join(timeout=20)
    (error,) = errors
    assert error.startswith(f"Scene file {path}: ") and message in error
