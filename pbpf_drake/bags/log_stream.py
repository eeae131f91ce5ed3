"""What all readers of a file's messages have in common."""

from collections.abc import Iterator
from dataclasses import dataclass
import mmap
from pathlib import Path
from typing import Protocol

from pbpf_drake.bags.log_error import LogError


@dataclass(frozen=True)
class RawMessage:
    """A message as the file holds it.

    Attributes:
        topic: its topic.
        type: the name of its type, "package/msg/Type" or "package/Type".
        encoding: how ``data`` is encoded: "cdr" for ROS 2, "ros1" for ROS 1.
        definition: the text that defines its type; empty where there is none.
        log_time: when it was received (in nanoseconds).
        data: the encoded message.
    """

    topic: str
    type: str
    encoding: str
    definition: str
    log_time: int
    data: bytes


class LogStream(Protocol):
    """The messages of one log on given topics, in the file's order.

    After ``Messages()`` is exhausted ``types`` and ``damage`` are complete.

    Attributes:
        kind: what kind of file it is, as "an MCAP file".
        types: by topic, the name of the type of its messages; all topics.
        damage: one sentence for everything that could not be read.
    """

    kind: str
    types: dict[str, str]
    damage: list[str]

    def Messages(self) -> Iterator[RawMessage]:
        """Yields the messages.

        Raises:
            LogError: the file can't be read at all.
        """
        ...


def open_bytes(filename: Path) -> mmap.mmap:
    """Returns a file's bytes, without loading them.

    Raises:
        LogError: it can't be opened, or it is empty.
    """
    try:
        with filename.open("rb") as file:
            return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except OSError as error:
        raise LogError(f"it can't be opened: {error.strerror}") from error
    except ValueError as error:
        raise LogError("it is empty") from error
