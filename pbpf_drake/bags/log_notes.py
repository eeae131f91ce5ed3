"""Counts what was left out of a log, and says it in sentences."""

from collections import Counter
from dataclasses import dataclass, replace


def plural(count: int, noun: str) -> str:
    """Returns "1 message", "2 messages" and so on."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


# What is left out is counted with this verb.
_LEFT_OUT = "left out"


@dataclass(frozen=True)
class _Kind:
    """What is counted together; see LogNotes.Count."""

    topic: str
    verb: str
    noun: str
    reason: str
    owner: str


class LogNotes:
    """Counts by topic what was left out or changed, and why."""

    def __init__(self) -> None:
        """Starts without notes."""
        self._counts: Counter[_Kind] = Counter()
        self._sentences: list[str] = []

    def On(self, topic: str, noun: str) -> "TopicNotes":
        """Returns what counts the things of one kind on one topic.

        Args:
            topic: where they are.
            noun: what one of them is, such as "message".
        """
        return TopicNotes(self, topic, noun)

    def Count(
        self, topic: str, verb: str, noun: str, reason: str, owner: str = ""
    ) -> None:
        """Counts one more ``noun`` of this kind.

        Args:
            topic: where it is.
            verb: what was done with it, such as "left out".
            noun: what it is, such as "message".
            reason: why, as a clause: "whose position is not finite".
            owner: the object that it is of; sentences don't tell them apart.
        """
        self._counts[_Kind(topic, verb, noun, reason, owner)] += 1

    def Add(self, sentence: str) -> None:
        """Adds a sentence that needs no counting."""
        self._sentences.append(sentence)

    def Sentences(self) -> tuple[str, ...]:
        """Returns all sentences."""
        counts: Counter[tuple[str, str, str, str]] = Counter()
        for k, count in self._counts.items():
            counts[k.topic, k.verb, k.noun, k.reason] += count
        counted = [
            f"{topic}: {verb} {plural(count, noun)} {reason}"
            for (topic, verb, noun, reason), count in counts.items()
        ]
        return tuple(self._sentences + counted)

    def LeftOut(self, topic: str, noun: str, owner: str) -> dict[str, int]:
        """Returns by reason how many things of one kind were left out."""
        return {
            k.reason: count
            for k, count in self._counts.items()
            if (k.topic, k.verb, k.noun, k.owner)
            == (topic, _LEFT_OUT, noun, owner)
        }


@dataclass(frozen=True)
class TopicNotes:
    """Counts the things of one kind on one topic.

    Attributes:
        notes: where the counts are kept.
        topic: where the things are.
        noun: what one of them is, such as "detection".
        owner: the object that they are of; empty where that isn't known.
    """

    notes: LogNotes
    topic: str
    noun: str
    owner: str = ""

    def Of(self, owner: str) -> "TopicNotes":
        """Returns what counts only the things of one object."""
        return replace(self, owner=owner)

    def CountLeftOut(self, reason: str) -> None:
        """Counts one more that is left out; see LogNotes.Count."""
        self.Count(_LEFT_OUT, reason)

    def Count(self, verb: str, reason: str) -> None:
        """Counts one more with which something was done."""
        self.notes.Count(self.topic, verb, self.noun, reason, self.owner)

    def LeftOut(self) -> dict[str, int]:
        """Returns by reason how many were left out."""
        return self.notes.LeftOut(self.topic, self.noun, self.owner)

    def Add(self, sentence: str) -> None:
        """Adds a sentence on the topic that needs no counting."""
        self.notes.Add(f"{self.topic}: {sentence}")
