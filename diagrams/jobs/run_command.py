"""Runs a command, and turns what ends it into a sentence."""

from collections.abc import Callable
import sys

# What shells give a command that SIGINT ended.
_INTERRUPTED = 130


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
    except KeyboardInterrupt:
        print(f"{name}: interrupted", file=sys.stderr)
        return _INTERRUPTED
    return 0
