"""The error for a log that can't be used."""


class LogError(ValueError):
    """A log can't be used; the message says what was expected and where."""
