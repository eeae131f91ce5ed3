"""The key of a job: all that its result depends on.

The program that asks for a result computes the key, to look for it among the
stored ones. The process that computes the result computes the key again: on
another machine, or hours later, code or files may have changed.
"""

from collections.abc import Mapping

# Names what a result depends on; JSON can hold the values.
JobKey = Mapping[str, object]

_EXPECTED = {
    "code": "the same code, and the same versions of Python and of what is "
    "installed",
    "scene": "the same scene and models, unchanged since the start",
}


def check_key(asked: JobKey, found: JobKey) -> None:
    """Raises ValueError unless both keys are the same.

    Args:
        asked: the key of the program that asks for a result.
        found: the key of the process that computes it.
    """
    other = [name for name in found if asked.get(name) != found[name]]
    if other:
        expected = [_EXPECTED.get(name, f"the same {name}") for name in other]
        raise ValueError(
            "the process that computes it finds something else than the "
            f"program that asks; expected {', '.join(expected)}"
        )
