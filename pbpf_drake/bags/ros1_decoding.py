"""Decodes messages of ROS 1 by the definitions that a bag carries."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any


def make_ros1_decoder(kind: str, definition: str) -> Callable[[bytes], Any]:
    """Returns what decodes messages of one type.

    Args:
        kind: the type's name.
        definition: its text, with that of all types in it.

    Raises:
        Exception: of any kind, if the definition can't be used.
    """
    store, name = _parse(kind, definition)
    return lambda data: store.deserialize_ros1(data, name)


@lru_cache(maxsize=1000)
def definition_matches(kind: str, definition: str, checksum: str) -> bool:
    """Tells if a definition has the MD5 sum that ROS 1 gives it."""
    try:
        store, name = _parse(kind, definition)
        # "*" stands for any.
        return checksum in ("*", store.generate_msgdef(name)[1])
    except Exception:  # Damage can show in any way.
        return False


@lru_cache(maxsize=1000)
def _parse(kind: str, definition: str) -> tuple[Any, str]:
    """Returns a store of types with this one in it, and its name there."""
    # It takes a while to import, and only bags need it.
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    name = kind if "/msg/" in kind else kind.replace("/", "/msg/")
    store = get_typestore(Stores.EMPTY)
    store.register(get_types_from_msg(definition, name))
    return store, name
