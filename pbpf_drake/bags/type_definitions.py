"""Parses the text that defines a message type, and checks what it asks for.

The text is part of a file, so that it may be damaged, or made to take forever:
a few lines can ask for more numbers than any computer holds.
"""

from dataclasses import dataclass
import re

from pbpf_drake.bags.ros2_messages import short_type_name

# How many values a message may have beside those of arrays without a length.
_MAX_VALUES = 10_000
_MAX_DEPTH = 50
_TYPE_NAME = re.compile(r"[A-Za-z]\w*(/msg)?/[A-Za-z]\w*", re.ASCII)
# Type, length of a string, array, its length, name.
_FIELD = re.compile(
    r"(?P<type>[A-Za-z]\w*(/[A-Za-z]\w*)*)(<=\d{1,9})?"
    r"(?P<array>\[(<=)?(?P<length>\d{0,18})\])?\s+"
    r"(?P<name>[A-Za-z]\w*)(?=\s|=|$)\s*(?P<constant>=)?",
    re.ASCII,
)
STRING = "string"
# By type: how long it is, and to what it is aligned in ROS 2 (in bytes). The
# text may leave out the times, which are the same in all releases.
PRIMITIVES: dict[str, tuple[int, int]] = {
    **{name: (1, 1) for name in ("bool", "byte", "char", "int8", "uint8")},
    **{name: (2, 2) for name in ("int16", "uint16")},
    **{name: (4, 4) for name in ("int32", "uint32", "float32")},
    **{name: (8, 8) for name in ("int64", "uint64", "float64")},
    **{name: (8, 4) for name in ("time", "duration")},
    "builtin_interfaces/Time": (8, 4),
    "builtin_interfaces/Duration": (8, 4),
}


@dataclass(frozen=True)
class Field:
    """A field of a type.

    Attributes:
        type: one of PRIMITIVES, STRING, or the name of another type.
        count: how many there are of it; None where each message says that.
    """

    type: str
    count: int | None = 1


# By the name of a type, its fields.
Types = dict[str, list[Field]]


def is_type_name(name: str) -> bool:
    """Tells if a type can have this name, "package/msg/Type" or shorter."""
    return bool(_TYPE_NAME.fullmatch(name))


def parse_definition(kind: str, text: str, limit: int) -> Types:
    """Returns all types in a text.

    Args:
        kind: the name of the type that it defines.
        text: its definition, with that of all types in it.
        limit: how long the text may be (in characters).

    Raises:
        ValueError: the definition is damaged, or asks for too much.
    """
    if len(text) > limit:
        raise ValueError(f"the definition of {kind!r} is too long")
    types = _parse(kind, text)
    _count_values(short_type_name(kind), types, {}, 0)
    return types


def _parse(kind: str, text: str) -> Types:
    """Returns the fields of all types in a text, by the types' names."""
    if not is_type_name(kind):
        raise ValueError(f"no type can be named {kind!r}")
    fields: list[Field] = []
    current, types = short_type_name(kind), {short_type_name(kind): fields}
    for line in text.splitlines():
        line = line.partition("#")[0].strip()
        if not line or re.fullmatch("={3,}", line):
            continue
        if line.startswith("MSG:"):
            current = short_type_name(line.removeprefix("MSG:").strip())
            if not is_type_name(current):
                raise ValueError(f"no type can be named {current!r}")
            types[current] = fields = []
            continue
        match = _FIELD.match(line)
        if match is None:
            raise ValueError(f"{line!r} defines no field")
        if not match["constant"]:
            kind = _resolve(match["type"], current)
            fields.append(Field(kind, _count(match)))
    return types


def _count(match: re.Match[str]) -> int | None:
    if not match["array"]:
        return 1
    # "<=" is before the most that a message may say.
    return int(match["length"]) if match["array"][1].isdigit() else None


def _resolve(name: str, parent: str) -> str:
    """Returns the full name of a type as a field of another type has it."""
    name = short_type_name(name)
    if "/" in name or name in PRIMITIVES or name == STRING:
        return name
    # ROS 1 has a short name for this one.
    package = "std_msgs" if name == "Header" else parent.partition("/")[0]
    return f"{package}/{name}"


def _count_values(
    name: str, types: Types, known: dict[str, int], depth: int
) -> int:
    """Returns how many values a type has, at least 1."""
    if name in PRIMITIVES or name == STRING:
        return 1
    if name not in known:
        if depth > _MAX_DEPTH:
            raise ValueError(f"the type {name!r} is nested too deeply")
        if not types.get(name):
            # Without one, an array of it would have no end.
            raise ValueError(f"the type {name!r} has no fields")
        known[name] = sum(
            (1 if field.count is None else field.count)
            * _count_values(field.type, types, known, depth + 1)
            for field in types[name]
        )
    if known[name] > _MAX_VALUES:
        raise ValueError(f"the type {name!r} has {known[name]} values")
    return known[name]
