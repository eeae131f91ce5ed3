"""How much of a log's input was used."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pbpf_drake.bags.log_notes import TopicNotes, plural

# What a detection is called where things are counted.
DETECTION = "detection"
# A larger share of detections than this that is left out is worth a warning.
MAX_LEFT_OUT = 0.1


@dataclass(frozen=True)
class InputUsage:
    """How much of what a source says of one thing was used.

    Attributes:
        source: a topic, or "tf:" and a frame.
        name: the tracked model that it is of; empty for joint states, and for
            what belongs to no model.
        noun: what is counted: "message" or "detection".
        read: how many there are.
        used: how many of them became part of the log.
        left_out: how many were not, by the reason as a clause. Together with
            ``used`` they are ``read``.
    """

    source: str
    name: str
    noun: str
    read: int
    used: int
    left_out: Mapping[str, int]

    @property
    def num_left_out(self) -> int:
        """How many were left out for any reason."""
        return sum(self.left_out.values())


def make_usage(notes: TopicNotes, *, read: int) -> InputUsage:
    """Returns what was used of what ``notes`` counts.

    Args:
        notes: have counted what was left out.
        read: how many there are.
    """
    left_out = notes.LeftOut()
    return InputUsage(
        source=notes.topic,
        name=notes.owner,
        noun=notes.noun,
        read=read,
        used=read - sum(left_out.values()),
        left_out=left_out,
    )


def usage_lines(rows: Sequence[InputUsage]) -> list[str]:
    """Returns a line on each of some counts.

    Args:
        rows: of one log.
    """
    lines = []
    for row in rows:
        what = f" of {row.name!r}" if row.name else ""
        line = (
            f"{row.source}: {plural(row.read, row.noun)}{what} read, "
            f"{row.used} used"
        )
        for reason, count in row.left_out.items():
            line += f"; {count} left out: {reason}"
        lines.append(line)
    return lines


def usage_warning(usage: InputUsage) -> str:
    """Returns a sentence if many detections of an object were left out.

    Args:
        usage: of anything; for anything else the sentence is empty.
    """
    left_out = usage.num_left_out
    is_of_object = usage.noun == DETECTION and usage.name
    if not is_of_object or left_out <= MAX_LEFT_OUT * usage.read:
        return ""
    return (
        f"{usage.source}: only {usage.used} of "
        f"{plural(usage.read, usage.noun)} of {usage.name!r} can be used"
    )


def count_usage(
    usage: list[InputUsage], notes: TopicNotes, *, read: int
) -> None:
    """Adds what was used of what ``notes`` counts, and warns if it is little.

    Args:
        usage: is added to.
        notes: have counted what was left out.
        read: how many there are.
    """
    usage.append(make_usage(notes, read=read))
    if warning := usage_warning(usage[-1]):
        notes.notes.Add(warning)
