"""Definitions of types: what they ask for is known before it is done."""

import pytest

from pbpf_drake.bags import ros2_messages
from pbpf_drake.bags.ros2_messages import message_definition
from pbpf_drake.bags.type_definitions import (
    Field,
    is_type_name,
    parse_definition,
)

LIMIT = 2**16
SEPARATOR = "\n" + "=" * 80 + "\n"


def _parse(text, kind="a/msg/A"):
    return parse_definition(kind, text, LIMIT)


def test_fields_and_arrays_are_found():
    text = """# A comment.
int32 X=5
string NAME = "a # b"
float64 w 1  # The default.
float64[36] covariance
string<=10[<=5] names
Header header
B[] items
uint8[] data"""
    others = ["MSG: std_msgs/Header\ntime stamp", "MSG: a/msg/B\nbool x"]
    types = _parse(SEPARATOR.join([text, *others]))
    assert types["a/A"] == [
        Field("float64"),
        Field("float64", 36),
        Field("string", None),
        Field("std_msgs/Header"),
        Field("a/B", None),
        Field("uint8", None),
    ]


def test_all_types_of_this_project_can_be_parsed():
    for name in ros2_messages._FIELDS:
        assert parse_definition(name, message_definition(name), LIMIT)[name]


@pytest.mark.parametrize(
    "text, reason",
    [
        ("string[2000000000] x", "has 2000000000 values"),
        ("\n".join(f"bool x{i}" for i in range(10_001)), "too long|values"),
        ("a/B[1000] x" + SEPARATOR + "MSG: a/B\nbool[1000] y", "1000000 val"),
        ("a/A x", "nested too deeply"),
        ("a/B[] x" + SEPARATOR + "MSG: a/B\nint8 X=1", "'a/B' has no fields"),
        ("a/B x", "'a/B' has no fields"),
        ("", "no fields"),
        ("float64 x\nimport os; os.system('ls')", "no field"),
        ("bool x" + SEPARATOR + "MSG: a/B:\n pass", "no type can be named"),
        ("x" * (LIMIT + 1), "too long"),
    ],
)
def test_what_has_no_end_is_refused(text, reason):
    with pytest.raises(ValueError, match=reason):
        _parse(text)


@pytest.mark.parametrize(
    "name", ["a/B", "a/msg/B", "sensor_msgs/msg/JointState"]
)
def test_types_have_a_package_and_a_name(name):
    assert is_type_name(name)


@pytest.mark.parametrize("name", ["", "B", "a/b:\n pass", "a/b/c", "ä/B"])
def test_nothing_else_is_a_types_name(name):
    assert not is_type_name(name)
    with pytest.raises(ValueError, match="no type can be named"):
        _parse("bool x", kind=name)
