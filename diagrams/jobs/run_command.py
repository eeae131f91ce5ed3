"""Runs a command, and says in a sentence why it failed."""

from collections.abc import Callable
import sys

# The exit code that shells report for a command that SIGINT has ended.
_INTERRUPTED = 130


def RunCommand(name: str, run: Callable[[], None]) -> int:
    """Returns the exit code of a command.

    Args:
        name: of the command; error messages start with it.
        run: does what the command is for. It raises a ValueError or an OSError
            with a message for the user.
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
