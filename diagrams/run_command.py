"""Runs a command, and turns what went wrong into a sentence."""

from collections.abc import Callable
import sys


def RunCommand(name: str, run: Callable[[], None]) -> int:
    """Returns the exit code of a command.

    Args:
        name: of the command; what goes wrong is printed behind it.
        run: does what the command is for; a ValueError or an OSError that it
            raises is the user's to read.
    """
    try:
        run()
    except (ValueError, OSError) as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 1
    return 0
