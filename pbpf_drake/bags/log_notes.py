"""Counts what was left out of a log, and says it in sentences."""

from collections import Counter


def plural(count: int, noun: str) -> str:
    """Returns "1 message", "2 messages" and so on."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


class LogNotes:
    """Counts by topic what was left out or changed, and why."""

    def __init__(self) -> None:
        """Starts without notes."""
        self._counts: Counter[tuple[str, str, str, str]] = Counter()
        self._sentences: list[str] = []

    def Count(self, topic: str, verb: str, noun: str, reason: str) -> None:
        """Counts one more ``noun`` of this kind.

        Args:
            topic: where it is.
            verb: what was done with it, such as "left out".
            noun: what it is, such as "message".
            reason: why, as a clause: "whose position is not finite".
        """
        self._counts[topic, verb, noun, reason] += 1

    def Add(self, sentence: str) -> None:
        """Adds a sentence that needs no counting."""
        self._sentences.append(sentence)

    def Sentences(self, topic: str | None = None) -> tuple[str, ...]:
        """Returns all sentences, or those that count things on one topic."""
        counted = [
            f"{where}: {verb} {plural(count, noun)} {reason}"
            for (where, verb, noun, reason), count in self._counts.items()
            if topic in (None, where)
        ]
        return tuple(([] if topic else self._sentences) + counted)
